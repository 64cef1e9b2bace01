// SPDX-License-Identifier: BSD-3-Clause
// The markers of boards, cell by cell.
#pragma once

#include <apriltag/apriltag.h>
#include <vector>

#include <opencv2/aruco.hpp>

#include "drivers/board_calibration/board.h"

namespace cliquevo::tools {

struct MarkerCells {
  int across = 0;
  std::vector<unsigned char> cells;  // 1 = black, row by row from the top

  bool black(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(across) + static_cast<std::size_t>(column)] !=
           0;
  }
};

// The smallest of the 5x5 dictionaries that has enough markers for a charuco board.
cv::aruco::PREDEFINED_DICTIONARY_NAME dictionary_for(const calibration::Board& board);
// With their black borders.
MarkerCells aruco_marker(const calibration::Board& board, int id);
MarkerCells april_tag(int id);  // 36h11 with Kalibr's border

// Kalibr's tags have a black border of two cells, those of the AprilTag library one.
inline constexpr int kKalibrsBorder = 2;
// The library's 36h11 with a border of so many cells; tag36h11_destroy() frees it.
apriltag_family_t* tag_family(int border);

}  // namespace cliquevo::tools
