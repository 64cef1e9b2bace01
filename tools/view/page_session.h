// SPDX-License-Identifier: BSD-3-Clause
// One page's WebSocket. Included by the two files that compile Boost.Beast.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>  // Boost 1.74 forgets it under C++20

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "tools/view/access.h"
#include "tools/view/server.h"
#include "tools/view/store.h"

namespace cliquevo::view {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using HttpRequest = http::request<http::empty_body>;

// What all pages are told, made once for all of them.
struct Told {
  std::shared_ptr<const std::string> state;
  std::shared_ptr<const std::string> mask;
};

class PageSession : public std::enable_shared_from_this<PageSession> {
 public:
  PageSession(beast::tcp_stream&& stream, const Store& store, const Telling& telling, const Told& told);
  void accept(const HttpRequest& request);
  // Sends what is due, if nothing is on its way.
  void pump();
  bool open() const { return open_; }
  void close();

 private:
  void read();
  void take(const std::string& text);
  void send(std::string message, bool text);
  std::optional<std::string> next_text();

  beast::websocket::stream<beast::tcp_stream> stream_;
  const Store& store_;
  const Telling& telling_;
  const Told& told_;
  beast::flat_buffer buffer_;
  std::string outgoing_;
  bool open_ = false;
  bool writing_ = false;
  bool greeted_ = false;
  std::int64_t next_record_ = 0;
  std::optional<PageCommand> wanted_;  // the newest request wins
  Told has_;                           // of what all are told
};

}  // namespace cliquevo::view
