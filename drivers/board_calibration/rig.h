// SPDX-License-Identifier: BSD-3-Clause
// The unknowns of a calibration that all views share, as one vector: lens of the left camera, lens of the right one,
// where the left camera is in the right one's frame, and how the board is bent.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/rigid_transform.h"
#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/lens.h"
#include "drivers/board_calibration/views.h"

namespace cliquevo::calibration {

inline constexpr int kFirstOfRight = kMostLens;
inline constexpr int kFirstOfPose = 2 * kMostLens;
inline constexpr int kFirstOfBend = kFirstOfPose + 6;
inline constexpr int kShared = kFirstOfBend + 2;

struct Rig {
  const LensModel* model = nullptr;
  LensVector left = LensVector::Zero();
  LensVector right = LensVector::Zero();
  RigidTransform T_right_left;
  // Height of the board's edges over its middle along x and along y, m: a parabola each.
  Eigen::Vector2d bend_m = Eigen::Vector2d::Zero();
  int width = 0;
  int height = 0;

  const LensVector& lens(Side side) const { return side == Side::left ? left : right; }
  LensVector& lens(Side side) { return side == Side::left ? left : right; }
  // Steps of the shared unknowns; the pose's is [translation, rotation vector] on the left.
  Rig moved(const Eigen::Matrix<double, kShared, 1>& step) const;
  StereoCalibration calibration() const;
};

// Which of the shared unknowns are estimated.
using SharedMask = std::array<bool, kShared>;
std::string shared_name(const Rig& rig, int index);

// A board's corner where it really is, and how it moves with the bend.
struct BentCorner {
  Eigen::Vector3d at;
  Eigen::Matrix<double, 1, 2> height_by_bend;
};
BentCorner bent_corner(const Board& board, int id, const Eigen::Vector2d& bend_m);

}  // namespace cliquevo::calibration
