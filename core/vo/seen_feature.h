// SPDX-License-Identifier: BSD-3-Clause
// What became of one feature of the last frame, for displays; nothing of the odometry depends on it.
#pragma once

#include <cstdint>

namespace cliquevo::vo {

// What became of a feature.
enum class FeatureRole : std::uint8_t {
  inlier = 0,     // the motion rests on it; seen in the frame before
  of_key = 1,     // likewise; seen in the kept older frame
  outlier = 2,    // found, but where the motion does not put it
  mover = 3,      // moves by itself
  not_found = 4,  // of the frame before: not found again where the motion puts it
  corner = 5,     // nothing to compare it with
};

// A feature and what became of it.
struct SeenFeature {
  float x_px = 0.0F;                       // in the left image
  float y_px = 0.0F;                       // in the left image
  float from_x_px = 0.0F;                  // in the image that it was compared with
  float from_y_px = 0.0F;                  // in the image that it was compared with
  float disparity_px = 0.0F;               // of the left image
  float error_px = 0.0F;                   // of an inlier or outlier
  FeatureRole role = FeatureRole::corner;  // what became of it
};

}  // namespace cliquevo::vo
