// SPDX-License-Identifier: BSD-3-Clause
// Bundle adjustment of a rig and the poses of a board: Levenberg-Marquardt on all reprojection errors at once, each
// view's pose eliminated (Schur complement; Triggs et al., Bundle adjustment: a modern synthesis, 2000).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "drivers/board_calibration/rig.h"

namespace cliquevo::calibration {

struct Adjusted {
  Rig rig;
  std::vector<RigidTransform> T_left_board;  // one a view
  bool converged = false;
  int iterations = 0;
  double sigma_px = 0.0;  // of one coordinate of a corner, from the residuals and the number of unknowns
  // Of the shared unknowns, rows and columns of those that are not estimated 0; of a corner's noise, sigma_px, and of
  // what its place is off by beyond that.
  Eigen::Matrix<double, kShared, kShared> covariance = Eigen::Matrix<double, kShared, kShared>::Zero();
};

struct AdjustmentOptions {
  SharedMask estimated{};
  bool robust = true;  // residuals beyond 2.5 robust standard deviations count linearly (Huber)
  int most_iterations = 100;
  double bend_sigma = 0.002;  // how much a board is expected to be bent, as a share of its half extent
  // One focal length a camera instead of two.
  bool square_pixels = false;
};

Adjusted adjust(const Board& board, const std::vector<View>& views, const Rig& start,
                const std::vector<RigidTransform>& T_left_board, const AdjustmentOptions& options);

// Reprojection errors of one side of a view, px; those that the lens model does not reach are NaN.
std::vector<Eigen::Vector2d> residuals(const Board& board, const Rig& rig, const RigidTransform& T_left_board,
                                       const View& view, Side side);

}  // namespace cliquevo::calibration
