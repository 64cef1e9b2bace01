// SPDX-License-Identifier: BSD-3-Clause
#include "tools/lcm_listener.h"

#include <utility>

#include <lcm/lcm-cpp.hpp>

#include "core/base/caught.h"
#include "daemon/lcm/lcm_url.h"

namespace cliquevo::tools {

struct LcmListener::Impl {
  Impl(const std::string& url, std::function<void(const ReceivedMessage&)> taken)
      : lcm(url), handler(std::move(taken)) {}

  static void receive(const lcm::ReceiveBuffer* buffer, const std::string& channel, Impl* self) {
    self->outcome = guarded("LCM", [&]() -> Result<void> {
      self->handler({channel, buffer->data, buffer->data_size});
      return {};
    });
  }

  lcm::LCM lcm;
  std::function<void(const ReceivedMessage&)> handler;
  Result<void> outcome;
};

LcmListener::LcmListener(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LcmListener::LcmListener(LcmListener&&) noexcept = default;
LcmListener& LcmListener::operator=(LcmListener&&) noexcept = default;
LcmListener::~LcmListener() = default;

Result<LcmListener> LcmListener::open(const std::string& url, const std::string& channels,
                                      std::function<void(const ReceivedMessage&)> handler) {
  if (auto ok = daemon::check_lcm_url(url); !ok) return ok.error();
  auto impl = std::make_unique<Impl>(url, std::move(handler));
  if (!impl->lcm.good()) return Error{"cannot receive LCM messages", url, "check the URL and the route"};
  if (impl->lcm.subscribeFunction(channels, &Impl::receive, impl.get()) == nullptr) {
    return Error{"cannot subscribe", channels, "name a channel, e.g. POSE_BODY"};
  }
  return LcmListener(std::move(impl));
}

Result<void> LcmListener::wait(int milliseconds) {
  if (impl_->lcm.handleTimeout(milliseconds) < 0) {
    return Error{"LCM does not receive any more", "LCM", "start again"};
  }
  return impl_->outcome;
}

}  // namespace cliquevo::tools
