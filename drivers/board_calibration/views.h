// SPDX-License-Identifier: BSD-3-Clause
// What was seen of a board: the corners of each pair of images.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace cliquevo::calibration {

struct SeenCorner {
  int id = 0;                                    // Board::corner
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw image, centre of the first pixel = 0
};

enum class Side { left = 0, right = 1 };

struct View {
  std::string name;  // for messages: file or number of the pair
  std::vector<SeenCorner> left;
  std::vector<SeenCorner> right;

  const std::vector<SeenCorner>& of(Side side) const { return side == Side::left ? left : right; }
  std::vector<SeenCorner>& of(Side side) { return side == Side::left ? left : right; }
};

}  // namespace cliquevo::calibration
