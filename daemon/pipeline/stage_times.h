// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cliquevo::daemon {

// How long the steps of one frame took.
struct StageTimes {
  std::int64_t rectify_ns = 0;
  std::int64_t stereo_ns = 0;
  std::int64_t odometry_ns = 0;
};

}  // namespace cliquevo::daemon
