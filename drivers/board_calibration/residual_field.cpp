// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/residual_field.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::calibration {

namespace {
constexpr int kLeastCorners = 5;  // of a cell that is judged
}

ResidualField residual_field(const Board& board, const Solution& s, Side side) {
  ResidualField out;
  const Rig& rig = s.rig();
  for (std::size_t v = 0; v < s.views.size(); ++v) {
    const auto errors = residuals(board, rig, s.adjusted.T_left_board[v], s.views[v], side);
    const std::vector<SeenCorner>& corners = s.views[v].of(side);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (!errors[i].allFinite()) continue;
      const auto place = [](double px, int size_px, int count) {
        return std::clamp(static_cast<int>(px * count / size_px), 0, count - 1);
      };
      const int column = place(corners[i].px.x(), rig.width, kFieldAcross);
      const int row = place(corners[i].px.y(), rig.height, kFieldDown);
      FieldCell& cell = out.cells[static_cast<std::size_t>(row) * kFieldAcross + static_cast<std::size_t>(column)];
      cell.mean_px += errors[i];
      ++cell.corners;
    }
  }
  double beyond = 0.0;
  double judged = 0.0;
  for (FieldCell& cell : out.cells) {
    if (cell.corners == 0) continue;
    cell.mean_px /= cell.corners;
    const double sigma = s.adjusted.sigma_px / std::sqrt(static_cast<double>(cell.corners));
    cell.sigmas = cell.mean_px.norm() / std::max(1e-9, sigma);
    if (cell.corners < kLeastCorners) continue;
    beyond += cell.mean_px.squaredNorm() - 2.0 * sigma * sigma;
    judged += 1.0;
  }
  out.structure_px = judged > 0.0 ? std::sqrt(std::max(0.0, beyond / judged)) : 0.0;
  return out;
}

}  // namespace cliquevo::calibration
