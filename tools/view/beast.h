// SPDX-License-Identifier: BSD-3-Clause
// Boost.Beast, which takes a compiler half a minute: for server.cpp and beast_web_socket.cpp alone.
#pragma once

#include <memory>
#include <string_view>
#include <utility>  // Boost 1.74 forgets it under C++20

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "tools/view/web_socket.h"

namespace cliquevo::view {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using HttpRequest = http::request<http::empty_body>;

// What the client asked for in `request`. Takes messages of up to most_bytes, and pings who is silent. protocol: that
// the answer names, "" for none.
std::unique_ptr<WebSocket> make_web_socket(beast::tcp_stream&& stream, const HttpRequest& request,
                                           std::size_t most_bytes, std::string_view protocol);
bool asks_for_web_socket(const HttpRequest& request);

}  // namespace cliquevo::view
