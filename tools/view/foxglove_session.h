// SPDX-License-Identifier: BSD-3-Clause
// One viewer that speaks foxglove.websocket.v1.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/view/foxglove_protocol.h"
#include "tools/view/ros2_topics.h"
#include "tools/view/session.h"
#include "tools/view/web_socket.h"

namespace cliquevo::view {

// Has one message on its way; the next is what the topics hold by then. What a client sends is read as it comes, and
// answered with one warning at a time.
class FoxgloveSession final : public Session, public std::enable_shared_from_this<FoxgloveSession> {
 public:
  FoxgloveSession(std::unique_ptr<WebSocket> socket, Ros2Topics& topics, const std::string& version);
  ~FoxgloveSession() override;
  FoxgloveSession(const FoxgloveSession&) = delete;
  FoxgloveSession& operator=(const FoxgloveSession&) = delete;
  void start() override;
  void pump() override;
  bool open() const override { return open_; }

 private:
  struct Subscription {
    std::uint32_t id = 0;
    Topic topic{};
    std::int64_t next = 0;  // message
  };
  void close();
  void read();
  void take(const std::string& text);
  void subscribe(const FoxgloveSubscription& wanted);
  void unsubscribe(std::uint32_t id);
  void drop_all();
  void send_text(std::string text);
  bool send_message();
  void sent(bool ok);

  const std::unique_ptr<WebSocket> socket_;
  Ros2Topics& topics_;
  std::deque<std::string> greetings_;
  std::optional<std::string> warning_;
  std::vector<Subscription> subscriptions_;
  std::size_t turn_ = 0;  // whose message goes next
  std::string text_;      // on its way, as is what follows
  std::array<std::uint8_t, kFoxgloveHeadBytes> head_{};
  Ros2Topics::Message message_;
  bool open_ = false;
  bool writing_ = false;
};

}  // namespace cliquevo::view
