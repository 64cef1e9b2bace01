// SPDX-License-Identifier: BSD-3-Clause
// What the odometry keeps of a frame for as long as it may serve as a reference.
#pragma once

#include <vector>

#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/features.h"
#include "core/vo/matches.h"

namespace cliquevo::vo {

struct Frame {
  explicit Frame(const VoParams& params) : descriptors(params.max_features) {
    features.reserve(static_cast<std::size_t>(params.max_features));
  }

  TimestampNs stamp_ns = 0;
  RigidTransform T_world_camera;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  std::vector<Feature> features;
  std::vector<Feature> witnesses;  // of the cells without a feature (core/vo/support.h); no points, no descriptors
  Descriptors descriptors;
};

}  // namespace cliquevo::vo
