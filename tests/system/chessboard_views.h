// SPDX-License-Identifier: BSD-3-Clause
// The corners of the 29 pairs of $CLIQUEVO_DATA/chessboard, for calibrations by others' code and by ours.
#pragma once

#include <vector>

#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/views.h"

namespace cliquevo::test {

struct ChessboardViews {
  calibration::Board board;
  std::vector<calibration::View> views;
  int width = 0;
  int height = 0;
};

ChessboardViews chessboard_views();

}  // namespace cliquevo::test
