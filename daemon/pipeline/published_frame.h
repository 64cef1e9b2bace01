// SPDX-License-Identifier: BSD-3-Clause
// What is published of one frame.
#pragma once

#include <cstdint>

#include "core/base/time.h"
#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/stage_times.h"

namespace cliquevo::daemon {

// A frame's way through the daemon, UTC; 0 = not measured.
struct FrameStamps {
  TimestampNs grabbed_ns = 0;
  TimestampNs stereo_begin_ns = 0;
  TimestampNs stereo_end_ns = 0;
  TimestampNs odometry_begin_ns = 0;
  TimestampNs odometry_end_ns = 0;
};

struct PublishedFrame {
  std::int64_t index = 0;
  vo::Estimate estimate;
  StageTimes times;
  std::int64_t dropped = 0;  // frames skipped so far
  std::int32_t resets = 0;   // rises with every pose reset
  FrameStamps stamps;
  vo::Movers movers;
};

}  // namespace cliquevo::daemon
