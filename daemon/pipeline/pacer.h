// SPDX-License-Identifier: BSD-3-Clause
// Plays recorded stamps at their own pace.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/base/saturating.h"
#include "core/base/time.h"

namespace cliquevo::daemon {

class Pacer {
 public:
  // speed: times the recorded pace, > 0.
  explicit Pacer(double speed) : speed_(speed) {}

  // When (monotonic) the frame with this stamp is due. A source that is late by more than a frame, e.g. as it has to
  // render first, shifts the schedule: a camera does not catch up by sending a burst either.
  std::int64_t due_ns(TimestampNs stamp_ns, std::int64_t now_ns) {
    const std::int64_t step_ns = started_ ? scaled(last_stamp_ns_, stamp_ns) : 0;
    std::int64_t due = started_ ? anchor_ns_ + scaled(anchor_stamp_ns_, stamp_ns) : now_ns;
    if (!started_ || now_ns > due + step_ns) {
      due = now_ns;
      anchor_ns_ = now_ns;
      anchor_stamp_ns_ = stamp_ns;
    }
    started_ = true;
    last_stamp_ns_ = stamp_ns;
    return due;
  }

 private:
  // Stamps of a damaged log may be any: half a century is as long as for ever.
  std::int64_t scaled(TimestampNs from_ns, TimestampNs to_ns) const {
    constexpr double kMostNs = 50.0 * 365.0 * 86400.0 * 1e9;
    const double span_ns = static_cast<double>(saturated_distance(to_ns, from_ns)) / speed_;
    const auto scaled_ns = static_cast<std::int64_t>(std::min(span_ns, kMostNs));
    return to_ns < from_ns ? -scaled_ns : scaled_ns;
  }

  double speed_;
  bool started_ = false;
  std::int64_t anchor_ns_ = 0;
  TimestampNs anchor_stamp_ns_ = 0;
  TimestampNs last_stamp_ns_ = 0;
};

}  // namespace cliquevo::daemon
