// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/page_session.h"

#include <utility>

namespace cliquevo::view {

namespace {
constexpr std::size_t kRecordsAtOnce = 400;
}  // namespace

PageSession::PageSession(std::unique_ptr<WebSocket> socket, const Store& store, const PageContent& content,
                         const SharedState& shared)
    : socket_(std::move(socket)), store_(store), content_(content), shared_(shared) {}

void PageSession::start() {
  socket_->accept([self = shared_from_this()](bool ok) {
    if (!ok) return;
    self->open_ = true;
    self->read();
    self->pump();
  });
}

void PageSession::close() {
  open_ = false;
  socket_->close();
}

void PageSession::read() {
  socket_->read([self = shared_from_this()](std::optional<WebSocket::Message> message) {
    if (!message) return self->close();
    self->take(message->content);
    if (self->open_) self->read();
  });
}

void PageSession::take(const std::string& text) {
  const auto command = parse_command(text);
  if (!command) return close();  // our page says nothing else
  if (command->what == PageCommand::What::frame) {
    wanted_ = command;
  } else {
    content_.command(command->what);
  }
  pump();
}

std::optional<std::string> PageSession::next_text() {
  if (!greeted_) {
    greeted_ = true;
    return content_.hello();
  }
  for (const auto part : {&SharedState::state, &SharedState::mask}) {
    if (shared_.*part == nullptr || shared_.*part == has_.*part) continue;
    has_.*part = shared_.*part;
    return *(has_.*part);
  }
  const Store::Extent extent = store_.extent();
  if (next_record_ >= extent.end) return std::nullopt;
  const std::string records = store_.records(next_record_, kRecordsAtOnce);
  return "{\"op\":\"records\",\"first\":" + std::to_string(extent.first) + ",\"records\":[" + records + "]}";
}

void PageSession::pump() {
  if (!open_ || writing_) return;
  if (wanted_ && greeted_) {
    const PageCommand wanted = *wanted_;
    wanted_.reset();
    const std::int64_t number = wanted.number < 0 ? store_.extent().end - 1 : wanted.number;
    return send(store_.frame_message(number, wanted.parts, wanted.have), false);
  }
  if (auto text = next_text()) send(std::move(*text), true);
}

void PageSession::send(std::string message, bool text) {
  writing_ = true;
  outgoing_ = std::move(message);
  socket_->write({}, outgoing_, text, [self = shared_from_this()](bool ok) {
    self->writing_ = false;
    if (!ok) return self->close();
    self->pump();
  });
}

}  // namespace cliquevo::view
