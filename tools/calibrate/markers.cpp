// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/markers.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

namespace cliquevo::tools {

cv::aruco::PREDEFINED_DICTIONARY_NAME dictionary_for(const calibration::Board& board) {
  const int markers = board.columns * board.rows / 2 + 1;
  if (markers <= 50) return cv::aruco::DICT_5X5_50;
  if (markers <= 100) return cv::aruco::DICT_5X5_100;
  return markers <= 250 ? cv::aruco::DICT_5X5_250 : cv::aruco::DICT_5X5_1000;
}

MarkerCells aruco_marker(const calibration::Board& board, int id) {
  constexpr int kAcross = 7;  // 5 bits and a border of 1
  cv::Mat drawn;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(dictionary_for(board)), id, kAcross, drawn, 1);
  MarkerCells out{kAcross, {}};
  for (int row = 0; row < kAcross; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      out.cells.push_back(drawn.at<unsigned char>(row, column) < 128 ? 1 : 0);
    }
  }
  return out;
}

apriltag_family_t* tag_family(int border) {
  apriltag_family_t* family = tag36h11_create();
  const int more = border - 1;
  family->width_at_border += 2 * more;
  family->total_width += 2 * more;
  for (std::uint32_t i = 0; i < family->nbits; ++i) {
    family->bit_x[i] += static_cast<std::uint32_t>(more);
    family->bit_y[i] += static_cast<std::uint32_t>(more);
  }
  return family;
}

MarkerCells april_tag(int id) {
  apriltag_family_t* family = tag_family(kKalibrsBorder);
  MarkerCells out{family->width_at_border, {}};
  const auto across = static_cast<std::size_t>(out.across);
  out.cells.assign(across * across, 1);
  const std::uint64_t code = family->codes[id];
  for (std::uint32_t i = 0; i < family->nbits; ++i) {
    const bool white = (code >> (family->nbits - 1 - i) & 1U) != 0;
    const auto at =
        static_cast<std::size_t>(family->bit_y[i]) * static_cast<std::size_t>(out.across) + family->bit_x[i];
    out.cells[at] = white ? 0 : 1;
  }
  tag36h11_destroy(family);
  return out;
}

}  // namespace cliquevo::tools
