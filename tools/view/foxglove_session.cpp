// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/foxglove_session.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace cliquevo::view {

namespace {
template <typename Bytes>
std::string_view bytes_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
}  // namespace

FoxgloveSession::FoxgloveSession(std::unique_ptr<WebSocket> socket, Ros2Topics& topics, const std::string& version)
    : socket_(std::move(socket)), topics_(topics) {
  // What was sent under another name is not to be taken for this session's.
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  greetings_.push_back(foxglove_server_info(version, std::to_string(now)));
  greetings_.push_back(foxglove_advertisement());
}

FoxgloveSession::~FoxgloveSession() { drop_all(); }

void FoxgloveSession::start() {
  socket_->accept([self = shared_from_this()](bool ok) {
    if (!ok) return;
    self->open_ = true;
    self->read();
    self->pump();
  });
}

void FoxgloveSession::close() {
  open_ = false;
  drop_all();
  socket_->close();
}

void FoxgloveSession::drop_all() {
  for (const Subscription& s : subscriptions_) topics_.count_subscriber(s.topic, -1);
  subscriptions_.clear();
}

void FoxgloveSession::read() {
  socket_->read([self = shared_from_this()](std::optional<WebSocket::Message> message) {
    if (!message) return self->close();
    // Binary messages are what a client publishes: nothing that was offered.
    if (message->text) self->take(message->content);
    if (self->open_) self->read();
  });
}

void FoxgloveSession::take(const std::string& text) {
  const auto request = parse_foxglove_request(text);
  if (!request) return close();  // no viewer sends such a thing
  for (const FoxgloveSubscription& wanted : request->subscribe) subscribe(wanted);
  for (const std::uint32_t id : request->unsubscribe) unsubscribe(id);
  pump();
}

void FoxgloveSession::subscribe(const FoxgloveSubscription& wanted) {
  const auto topic = topic_of_channel(wanted.channel);
  const bool taken = std::any_of(subscriptions_.begin(), subscriptions_.end(),
                                 [&](const Subscription& s) { return s.id == wanted.id; });
  if (!topic) {
    warning_ = foxglove_warning("there is no channel " + std::to_string(wanted.channel));
  } else if (taken) {
    warning_ = foxglove_warning("subscription " + std::to_string(wanted.id) + " is there already");
  } else if (subscriptions_.size() >= kMostSubscriptions) {
    warning_ = foxglove_warning("no more than " + std::to_string(kMostSubscriptions) + " subscriptions");
  } else {
    topics_.count_subscriber(*topic, 1);
    subscriptions_.push_back({wanted.id, *topic, topics_.newest(*topic)});
  }
}

void FoxgloveSession::unsubscribe(std::uint32_t id) {
  const auto found =
      std::find_if(subscriptions_.begin(), subscriptions_.end(), [id](const Subscription& s) { return s.id == id; });
  if (found == subscriptions_.end()) return;
  topics_.count_subscriber(found->topic, -1);
  subscriptions_.erase(found);
}

void FoxgloveSession::pump() {
  if (!open_ || writing_) return;
  if (!greetings_.empty()) {
    std::string next = std::move(greetings_.front());
    greetings_.pop_front();
    return send_text(std::move(next));
  }
  if (warning_) return send_text(*std::exchange(warning_, std::nullopt));
  send_message();
}

void FoxgloveSession::send_text(std::string text) {
  writing_ = true;
  text_ = std::move(text);
  socket_->write({}, text_, true, [self = shared_from_this()](bool ok) { self->sent(ok); });
}

// Of the next subscription that has one: pictures do not hold up poses.
bool FoxgloveSession::send_message() {
  for (std::size_t tried = 0; tried < subscriptions_.size(); ++tried) {
    Subscription& s = subscriptions_[turn_++ % subscriptions_.size()];
    auto message = topics_.take(s.topic, s.next);
    if (!message) continue;
    writing_ = true;
    message_ = std::move(*message);
    head_ = foxglove_message_head(s.id, message_.stamp_ns);
    socket_->write(bytes_of(head_), bytes_of(*message_.cdr), false,
                   [self = shared_from_this()](bool ok) { self->sent(ok); });
    return true;
  }
  return false;
}

void FoxgloveSession::sent(bool ok) {
  writing_ = false;
  message_ = {};
  if (!ok) return close();
  pump();
}

}  // namespace cliquevo::view
