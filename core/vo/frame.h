// SPDX-License-Identifier: BSD-3-Clause
// What the odometry keeps of a frame for as long as it may serve as a reference.
#pragma once

#include <vector>

#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/features.h"
#include "core/vo/matches.h"
#include "core/vo/rolling_shutter.h"

namespace cliquevo::vo {

struct Frame {
  explicit Frame(const VoParams& params) : descriptors(params.max_features), coarse_descriptors(params.max_features) {
    features.reserve(static_cast<std::size_t>(params.max_features));
  }

  TimestampNs stamp_ns = 0;
  RigidTransform T_world_camera;
  // Between the left and the right image: how much lower the right one is than the calibration has it, and how patches
  // scatter about that, px; 0 where too few were found. And their difference, grey levels.
  double row_shift_px = 0.0;
  double row_scatter_px = 0.0;
  double grey_scatter = 0.0;
  // Rolling shutters only: velocity at the stamp, and the mean one since the frame before.
  Velocity velocity = Velocity::Zero();
  Velocity velocity_before = Velocity::Zero();
  Eigen::Vector3d turn_rate = Eigen::Vector3d::Zero();  // beside it, rad/s
  // One camera's image is bit for bit the one before, the other's is not: no camera sees the same noise twice.
  bool one_camera_repeats = false;
  double shift_px = 0.0;  // by which all its disparities were found too large, beside the calibration's error
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  std::vector<Feature> features;
  std::vector<Feature> test_patches;  // of the cells without a feature (image_consistency.h); no points, no descriptors
  Descriptors descriptors;
  Descriptors coarse_descriptors;  // of half the resolution, for blurred and small pictures
};

// Velocities at the stamps of two frames, from the motion between them and the one before: the first lies between two
// means, the second beyond the last.
struct Velocities {
  Velocity before;  // mean between the two
  Velocity reference;
  Velocity current;
};
Velocities velocities(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur);

}  // namespace cliquevo::vo
