// SPDX-License-Identifier: BSD-3-Clause
// OpenCV's stereo calibration as most programs use it: each camera alone, then both together.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/views.h"

namespace cliquevo::test {

struct OpenCvRig {
  std::array<std::array<double, 8>, 2> lenses{};  // fx, fy, cx, cy, k1, k2, p1, p2, by Side
  double baseline_m = 0.0;
  double rms_px = 0.0;  // length of the reprojection error
};

// Of the corners that both cameras see.
OpenCvRig by_opencv(const calibration::Board& board, const std::vector<calibration::View>& views, cv::Size size);

}  // namespace cliquevo::test
