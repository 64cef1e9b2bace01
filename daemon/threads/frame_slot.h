// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "daemon/pipeline/published_frame.h"
#include "daemon/pipeline/stages.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

// A frame on its way through the daemon's threads. Whoever holds the slot owns all of it.
struct FrameSlot {
  drivers::StereoPair pair;
  StereoFrame frame;
  FrameStamps stamps;
  std::int64_t grabbed_mono_ns = 0;  // monotonic_ns() at stamps.grabbed_ns
};

}  // namespace cliquevo::daemon
