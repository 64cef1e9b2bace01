// SPDX-License-Identifier: BSD-3-Clause
// First values for the adjustment: nothing is assumed about the cameras.
#pragma once

#include <optional>
#include <vector>

#include "drivers/board_calibration/adjustment.h"

namespace cliquevo::calibration {

// One camera alone, its corners in View::left: the lens, and a pose a view. None where no focal length fits.
struct OneCamera {
  LensVector lens = LensVector::Zero();
  std::vector<RigidTransform> T_camera_board;
  double sigma_px = 0.0;
};
std::optional<OneCamera> calibrate_one(const Board& board, const std::vector<View>& views, const LensModel& model,
                                       int width, int height);

// Pose of the board from directions to its corners (a plane's homography by least squares, made rigid).
std::optional<RigidTransform> pose_from_rays(const Board& board, const std::vector<SeenCorner>& corners,
                                             const std::vector<Eigen::Vector3d>& rays);

}  // namespace cliquevo::calibration
