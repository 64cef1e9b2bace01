// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/base/result.h"

namespace cliquevo::stereo {

// Size and field of view of the rectified pair. Both cost nothing: the maps that rectify take care of them.
struct RectifyParams {
  // Rectified image's width and height as a share of the raw one's, 0.05..2; none: 1, the native size.
  std::optional<double> scale;
  // Horizontal field of view of the rectified image, degrees, 10..150; none: as the calibration prescribes, else all
  // that leaves no border without a source, at most kMostFovDeg.
  std::optional<double> fov_deg;

  // A pinhole image of more is mostly stretched rim: at 120 degrees the edge is magnified four times as much as the
  // middle, at 150 degrees fifteen times.
  static constexpr double kMostFovDeg = 120.0;

  // Whether size and field of view are the calibration's own.
  bool native() const { return scale.value_or(1.0) == 1.0 && !fov_deg; }
  // Names what is out of range.
  Result<void> check() const;
};

}  // namespace cliquevo::stereo
