// SPDX-License-Identifier: BSD-3-Clause
// Frames as the odometry would give them, made up for tests of what goes out.
#pragma once

#include "daemon/pipeline/published_frame.h"

namespace cliquevo::daemon {

inline constexpr TimestampNs kFirstStampNs = 1'700'000'000'123'456'789;
inline constexpr TimestampNs kPeriodNs = 33'333'333;

// Camera looking forward, level, 0.3 m ahead of and 0.5 m above the body's origin.
inline RigidTransform forward_camera() {
  RigidTransform T;
  T.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.t = {0.3, 0.0, 0.5};
  return T;
}

inline PublishedFrame frame_at(std::int64_t index, vo::Status status, const RigidTransform& T_world_camera) {
  PublishedFrame frame;
  frame.index = index;
  frame.estimate.status = status;
  frame.estimate.stamp_ns = kFirstStampNs + index * kPeriodNs;
  frame.estimate.T_world_camera = T_world_camera;
  return frame;
}

// The frame after `before` (a valid or first one), `steps` periods later, moved by `motion`.
inline PublishedFrame next_valid(const PublishedFrame& before, const RigidTransform& motion, std::int64_t steps = 1) {
  PublishedFrame frame = frame_at(before.index + steps, vo::Status::valid, before.estimate.T_world_camera * motion);
  frame.estimate.prev_stamp_ns = before.estimate.stamp_ns;
  frame.estimate.T_prev_cur = motion;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) frame.estimate.covariance(r, c) = (r == c ? 1e-4 : 1e-6) * (1 + r + c);
  }
  return frame;
}

}  // namespace cliquevo::daemon
