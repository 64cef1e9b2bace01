// SPDX-License-Identifier: BSD-3-Clause
// A board that is held still is seen several times in one place: the mean of its corners has less noise.
#pragma once

#include <array>
#include <map>

#include "drivers/board_calibration/views.h"

namespace cliquevo::tools {

class HeldView {
 public:
  HeldView() = default;
  explicit HeldView(const calibration::View& first);

  // Whether a pair shows the board where it was, so near that the mean of its corners is its view from its mean pose.
  bool is_same_place(const calibration::View& again) const;
  // Corners that it lacks are left out of the mean, too.
  void add(const calibration::View& again);
  calibration::View mean() const;
  int pairs() const { return pairs_; }

 private:
  calibration::View first_;
  std::array<std::map<int, Eigen::Vector2d>, 2> sums_;  // by Side and number of the corner
  int pairs_ = 0;
};

}  // namespace cliquevo::tools
