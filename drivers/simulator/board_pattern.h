// SPDX-License-Identifier: BSD-3-Clause
// What is printed on a calibration board, place by place.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/result.h"
#include "drivers/board_calibration/board.h"

namespace cliquevo::drivers::sim {

class BoardPattern {
 public:
  // Fails for a board with more markers than the simulator knows.
  static Result<BoardPattern> make(const calibration::Board& board);

  enum class Ink { none, white, black };  // none: beside the board
  struct Place {
    Ink ink = Ink::none;
    double clear_m = 0.0;  // within this distance it is the same everywhere, at least
  };
  // x, y in the board's frame, m.
  Place at(double x, double y) const;

  const calibration::Board& board() const { return board_; }
  Eigen::Vector2d middle() const { return 0.5 * (low_ + high_); }
  double width_m() const { return high_.x() - low_.x(); }
  // Around the sheet: its corners and three places on each edge.
  std::vector<Eigen::Vector3d> outline() const;

 private:
  explicit BoardPattern(const calibration::Board& board);
  Place squares(double x, double y) const;
  Place tags(double x, double y) const;
  Place dots(double x, double y) const;
  Place aruco_cell(int id, double x, double y, double side) const;

  calibration::Board board_;
  Eigen::Vector2d low_, high_;                  // of the sheet
  Eigen::Vector2d printed_low_, printed_high_;  // of what is printed on it
};

}  // namespace cliquevo::drivers::sim
