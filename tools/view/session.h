// SPDX-License-Identifier: BSD-3-Clause
// A WebSocket that the server keeps, and what its kinds share. Included by the files that compile Boost.Beast.
#pragma once

#include <utility>  // Boost 1.74 forgets it under C++20

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

namespace cliquevo::view {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using HttpRequest = http::request<http::empty_body>;

class Session {
 public:
  virtual ~Session() = default;
  virtual void accept(const HttpRequest& request) = 0;
  // Sends what is due, if nothing is on its way.
  virtual void pump() = 0;
  virtual bool open() const = 0;
};

using WebSocket = beast::websocket::stream<beast::tcp_stream>;

// As every session has it: most_bytes of a message that comes in, a ping to who is silent.
inline void set_options(WebSocket& stream, std::size_t most_bytes) {
  beast::get_lowest_layer(stream).expires_never();
  auto patience = beast::websocket::stream_base::timeout::suggested(beast::role_type::server);
  patience.keep_alive_pings = true;
  stream.set_option(patience);
  stream.read_message_max(most_bytes);
  stream.auto_fragment(false);  // else 4 KiB a frame, and a turn of the loop for each
}

}  // namespace cliquevo::view
