// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

namespace cliquevo {

// Time of an exposure: ns since the Unix epoch, UTC (recordings keep the stamps they have, whatever their zero).
using TimestampNs = std::int64_t;

// Now on the monotonic clock, for measuring how long things take.
inline std::int64_t monotonic_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace cliquevo
