// SPDX-License-Identifier: BSD-3-Clause
// Looks at an LCM URL before LCM does, so that a bad one gives one clear line; LCM prints paragraphs.
#pragma once

#include <cstdint>
#include <netinet/in.h>
#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

struct MulticastUrl {
  in_addr group{};
  std::uint16_t port = 0;
  int ttl = 0;  // LCM's own default
};
Result<MulticastUrl> parse_multicast_url(const std::string& url);

struct ServerUrl {
  std::string host;
  std::uint16_t port = 0;
};
Result<ServerUrl> parse_server_url(const std::string& url);

// udpm://A.B.C.D:PORT[?ttl=N&recv_buf_size=N] (multicast; fails without a route), tcpq://HOST:PORT (fails when nobody
// answers as an LCM server), file://PATH?mode=w (an event log), memq:// (within the process).
Result<void> check_lcm_url(const std::string& url);

}  // namespace cliquevo::daemon
