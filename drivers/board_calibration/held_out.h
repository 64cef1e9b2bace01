// SPDX-License-Identifier: BSD-3-Clause
// How well a calibration holds on views that it was not made from.
#pragma once

#include "drivers/board_calibration/solve.h"

namespace cliquevo::calibration {

// Five calibrations, each without a fifth of the solution's views, judged on that fifth.
HeldOut hold_out(const Board& board, const Solution& solution, const AdjustmentOptions& options);

// Differences of rows, left less right, of the corners that both cameras see, after rectification; px.
std::vector<double> row_differences(const Rig& rig, const View& view);

}  // namespace cliquevo::calibration
