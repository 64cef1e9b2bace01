// SPDX-License-Identifier: BSD-3-Clause
// Who may request what: everything that is decided from a request's text alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cliquevo::view {

struct AccessRules {
  std::uint16_t port = 0;
  std::string token;  // empty: loopback only, none is required
  // Whose pages may connect as viewers ("http://localhost:8080"), beside our own: --allow-origin.
  std::vector<std::string> viewer_origins;
};

// What of a request's head matters; empty = not there.
struct RequestHead {
  std::string_view method;
  std::string_view target;
  std::string_view host;
  std::string_view origin;
  std::string_view cookie;
  bool upgrade = false;        // to a WebSocket
  std::string_view protocols;  // that it offers to speak there
};

struct Judgement {
  int status = 200;         // of HTTP; 200: `path` may be served, or the WebSocket opened
  std::string path;         // without what follows ?
  bool viewer = false;      // a WebSocket for foxglove.websocket.v1
  bool set_cookie = false;  // the token came in the address: later requests bring it as a cookie
};

// A page of another site cannot pass: its name is in Host (so a name that was bound to this address does not help it)
// or in Origin. As a viewer it passes where it was named: viewers give no commands. Numbers and localhost may be a
// host's name, nothing else.
Judgement judge(const RequestHead& request, const AccessRules& rules);
std::string cookie_name(const AccessRules& rules);

// What a page may send.
struct PageCommand {
  enum class What { frame, record_start, record_stop, take_view, drop_view, finish };
  What what = What::frame;
  std::int64_t number = 0;  // of the frame, -1: the newest
  unsigned parts = 0;       // PartMask
  std::int64_t have = -1;   // frame whose images the page has, -1: none
};
std::optional<PageCommand> parse_command(std::string_view text);
inline constexpr std::size_t kMostCommandBytes = 1024;

}  // namespace cliquevo::view
