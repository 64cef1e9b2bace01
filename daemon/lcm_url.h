// SPDX-License-Identifier: BSD-3-Clause
// Looks at an LCM URL before LCM does, so that a bad one gives one clear line; LCM prints paragraphs.
#pragma once

#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

// udpm://A.B.C.D:PORT[?ttl=N&recv_buf_size=N] (multicast; fails without a route), tcpq://HOST:PORT (fails when nobody
// listens), file://PATH?mode=w (an event log), memq:// (within the process).
Result<void> check_lcm_url(const std::string& url);

}  // namespace cliquevo::daemon
