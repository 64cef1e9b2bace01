// SPDX-License-Identifier: BSD-3-Clause
// Plays recorded stamps at their own pace.
#pragma once

#include <cstdint>

#include "core/base/time.h"

namespace cliquevo::daemon {

class Pacer {
 public:
  // speed: times the recorded pace, > 0.
  explicit Pacer(double speed) : speed_(speed) {}

  // When (monotonic) the frame with this stamp is due. A source that is late by more than a frame, e.g. as it has to
  // render first, shifts the schedule: a camera does not catch up by sending a burst either.
  std::int64_t due_ns(TimestampNs stamp_ns, std::int64_t now_ns) {
    const std::int64_t step_ns = started_ ? scaled(stamp_ns - last_stamp_ns_) : 0;
    std::int64_t due = started_ ? anchor_ns_ + scaled(stamp_ns - anchor_stamp_ns_) : now_ns;
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
  std::int64_t scaled(std::int64_t span_ns) const {
    return static_cast<std::int64_t>(static_cast<double>(span_ns) / speed_);
  }

  double speed_;
  bool started_ = false;
  std::int64_t anchor_ns_ = 0;
  TimestampNs anchor_stamp_ns_ = 0;
  TimestampNs last_stamp_ns_ = 0;
};

}  // namespace cliquevo::daemon
