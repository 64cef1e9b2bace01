// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/message_sender.h"

#include <utility>

#include <lcm/lcm-cpp.hpp>

#include "daemon/lcm/lcm_url.h"
#include "daemon/lcm/tcpq_client.h"

namespace cliquevo::daemon {

namespace {

// Without a subscription LCM reads no socket.
class LcmSender final : public MessageSender {
 public:
  explicit LcmSender(const std::string& url) : lcm_(url) {}
  bool good() { return lcm_.good(); }
  bool send(const std::string& channel, const std::uint8_t* data, std::size_t size) override {
    return lcm_.publish(channel, data, static_cast<unsigned int>(size)) == 0;
  }

 private:
  lcm::LCM lcm_;
};

class TcpqSender final : public MessageSender {
 public:
  explicit TcpqSender(std::unique_ptr<TcpqClient> client) : client_(std::move(client)) {}
  bool send(const std::string& channel, const std::uint8_t* data, std::size_t size) override {
    return client_->send(channel, data, size);
  }

 private:
  std::unique_ptr<TcpqClient> client_;
};

}  // namespace

Result<std::unique_ptr<MessageSender>> MessageSender::open(const std::string& url) {
  if (url.starts_with("tcpq:")) {
    auto client = TcpqClient::open(url);
    if (!client) return client.error();
    return std::unique_ptr<MessageSender>(std::make_unique<TcpqSender>(std::move(*client)));
  }
  if (const auto ok = check_lcm_url(url); !ok) return ok.error();
  auto sender = std::make_unique<LcmSender>(url);
  if (!sender->good()) return Error{"LCM does not start", url, "check the URL and the multicast route"};
  return std::unique_ptr<MessageSender>(std::move(sender));
}

}  // namespace cliquevo::daemon
