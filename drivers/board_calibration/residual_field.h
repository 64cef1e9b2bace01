// SPDX-License-Identifier: BSD-3-Clause
// What reprojection errors are left over where in the image: noise has no pattern, a lens model that is too simple has.
#pragma once

#include <array>
#include <vector>

#include "drivers/board_calibration/solve.h"

namespace cliquevo::calibration {

inline constexpr int kFieldAcross = 8;
inline constexpr int kFieldDown = 6;

struct FieldCell {
  int corners = 0;
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double sigmas = 0.0;  // length of the mean, in standard deviations of a mean of so many
};

struct ResidualField {
  std::array<FieldCell, static_cast<std::size_t>(kFieldAcross* kFieldDown)> cells;  // row by row
  double structure_px = 0.0;  // RMS of the means beyond what noise makes of them: 0 where nothing is left over
};

ResidualField residual_field(const Board& board, const Solution& solution, Side side);

}  // namespace cliquevo::calibration
