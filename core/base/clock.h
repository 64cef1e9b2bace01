// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

#include "core/base/time.h"

namespace cliquevo {

// Now, UTC; what stamps in messages are. It may be set back: measure durations with monotonic_ns().
inline TimestampNs utc_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace cliquevo
