// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <string>

#include <boost/asio/buffer.hpp>
#include <boost/beast/websocket.hpp>

#include "tools/view/beast.h"

namespace cliquevo::view {

namespace {

class BeastWebSocket final : public WebSocket {
 public:
  BeastWebSocket(beast::tcp_stream&& stream, HttpRequest request, std::size_t most_bytes, std::string_view protocol)
      : stream_(std::move(stream)), request_(std::move(request)) {
    beast::get_lowest_layer(stream_).expires_never();
    auto patience = beast::websocket::stream_base::timeout::suggested(beast::role_type::server);
    patience.keep_alive_pings = true;
    stream_.set_option(patience);
    stream_.read_message_max(most_bytes);
    stream_.auto_fragment(false);  // else 4 KiB a frame, and a turn of the loop for each
    if (protocol.empty()) return;
    stream_.set_option(beast::websocket::stream_base::decorator(
        [name = std::string(protocol)](beast::websocket::response_type& response) {
          response.set(http::field::sec_websocket_protocol, name);
        }));
  }

  void accept(std::function<void(bool)> done) override {
    stream_.async_accept(request_, [done = std::move(done)](beast::error_code error) { done(!error); });
  }

  void read(std::function<void(std::optional<Message>)> done) override {
    stream_.async_read(buffer_, [this, done = std::move(done)](beast::error_code error, std::size_t) {
      if (error) return done(std::nullopt);
      Message message{beast::buffers_to_string(buffer_.data()), stream_.got_text()};
      buffer_.consume(buffer_.size());
      done(std::move(message));
    });
  }

  void write(std::string_view head, std::string_view body, bool text, std::function<void(bool)> done) override {
    const std::array<asio::const_buffer, 2> all{asio::buffer(head), asio::buffer(body)};
    stream_.text(text);
    stream_.async_write(all, [done = std::move(done)](beast::error_code error, std::size_t) { done(!error); });
  }

  void close() override {
    beast::error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

 private:
  beast::websocket::stream<beast::tcp_stream, false> stream_;  // false: compression is not offered
  const HttpRequest request_;
  beast::flat_buffer buffer_;
};

}  // namespace

std::unique_ptr<WebSocket> make_web_socket(beast::tcp_stream&& stream, const HttpRequest& request,
                                           std::size_t most_bytes, std::string_view protocol) {
  return std::make_unique<BeastWebSocket>(std::move(stream), request, most_bytes, protocol);
}

bool asks_for_web_socket(const HttpRequest& request) { return beast::websocket::is_upgrade(request); }

}  // namespace cliquevo::view
