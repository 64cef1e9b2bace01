// SPDX-License-Identifier: BSD-3-Clause
// Calibration boards: which corners they have, and where.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/result.h"

namespace cliquevo::calibration {

enum class BoardKind {
  chessboard,  // columns x rows inner corners; size = side of a square
  charuco,     // columns x rows squares, markers in the white ones; size = side of a square
  aprilgrid,   // columns x rows tags as Kalibr prints them, the first at the lower left; size = side of a tag
  circles,     // columns x rows dots in a rectangular grid; size = distance of neighbours
};

struct Board {
  BoardKind kind = BoardKind::chessboard;
  int columns = 0;
  int rows = 0;
  double size_m = 0.0;
  // charuco: side of a marker over that of a square. aprilgrid: gap between tags over a tag's side.
  double ratio = 0.0;

  int corner_count() const;
  // In the board's frame, z = 0; x along a row, y along a column.
  Eigen::Vector3d corner(int id) const;
  // Half of the extent of all corners, and their middle.
  Eigen::Vector2d half_extent() const;
  Eigen::Vector2d middle() const;
  // As on the command line.
  std::string text() const;
};

// KIND:COLSxROWS:SIZE_M[:RATIO]. The ratio is 0.75 for charuco and 0.3 for aprilgrid where it is left out.
Result<Board> parse_board(const std::string& text);
const char* board_kind_name(BoardKind kind);

}  // namespace cliquevo::calibration
