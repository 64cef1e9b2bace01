// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/page_session.h"

#include <boost/asio/buffer.hpp>

namespace cliquevo::view {

namespace {
constexpr std::size_t kRecordsAtOnce = 400;
}  // namespace

PageSession::PageSession(beast::tcp_stream&& stream, const Store& store, const PageContent& content,
                         const SharedState& shared)
    : stream_(std::move(stream)), store_(store), content_(content), shared_(shared) {}

void PageSession::accept(const HttpRequest& request) {
  set_options(stream_, kMostCommandBytes);
  stream_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) return;
    self->open_ = true;
    self->read();
    self->pump();
  });
}

void PageSession::close() {
  open_ = false;
  beast::error_code ignored;
  beast::get_lowest_layer(stream_).socket().close(ignored);
}

void PageSession::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error) return self->close();
    const std::string text = beast::buffers_to_string(self->buffer_.data());
    self->buffer_.consume(self->buffer_.size());
    self->take(text);
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
  stream_.text(text);
  stream_.async_write(asio::buffer(outgoing_), [self = shared_from_this()](beast::error_code error, std::size_t) {
    self->writing_ = false;
    if (error) return self->close();
    self->pump();
  });
}

}  // namespace cliquevo::view
