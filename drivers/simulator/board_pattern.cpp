// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/board_pattern.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/simulator/marker_tables.h"

namespace cliquevo::drivers::sim {

namespace {

using calibration::Board;
using calibration::BoardKind;

constexpr double kWideMargin = 0.7;    // white around it, of a square's side
constexpr double kNarrowMargin = 0.3;  // around boards with markers
constexpr double kDotRadius = 0.25;    // of the distance of neighbours, as boards are printed
constexpr int kArucoAcross = 7;        // cells, with the border of 1
constexpr int kTagAcross = 10;         // with Kalibr's border of 2

bool has_markers(BoardKind kind) { return kind == BoardKind::charuco || kind == BoardKind::aprilgrid; }

int markers_of(const Board& b) {
  if (b.kind == BoardKind::charuco) return b.columns * b.rows / 2;
  return b.kind == BoardKind::aprilgrid ? b.columns * b.rows : 0;
}

// To the nearest multiple of a step.
double to_line(double v, double step) { return std::abs(v - std::round(v / step) * step); }

// From a place to a rectangle's edges: inside positive, outside negative.
double within(double x, double y, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  return std::min({x - low.x(), high.x() - x, y - low.y(), high.y() - y});
}

BoardPattern::Place place(bool black, double clear_m) {
  return {black ? BoardPattern::Ink::black : BoardPattern::Ink::white, clear_m};
}

}  // namespace

Result<BoardPattern> BoardPattern::make(const Board& board) {
  constexpr int kMost = static_cast<int>(kAruco5x5.size());
  if (markers_of(board) > kMost) {
    return Error{"bad simulator option", "board = " + board.text(),
                 fmt::format("the simulator knows {} markers: use a smaller board", kMost)};
  }
  return BoardPattern(board);
}

BoardPattern::BoardPattern(const Board& board) : board_(board) {
  const double s = board.size_m;
  switch (board.kind) {
    case BoardKind::chessboard:
      printed_low_ = {-s, -s};
      printed_high_ = {board.columns * s, board.rows * s};
      break;
    case BoardKind::charuco:
      printed_low_ = {-s, -s};
      printed_high_ = {(board.columns - 1) * s, (board.rows - 1) * s};
      break;
    case BoardKind::aprilgrid:
      printed_low_ = Eigen::Vector2d::Constant(-s * board.ratio);
      printed_high_ = Eigen::Vector2d(board.columns, board.rows) * s * (1.0 + board.ratio);
      break;
    case BoardKind::circles:
      printed_low_ = Eigen::Vector2d::Constant(-kDotRadius * s);
      printed_high_ =
          Eigen::Vector2d(board.columns - 1, board.rows - 1) * s + Eigen::Vector2d::Constant(kDotRadius * s);
      break;
  }
  const double margin = s * (has_markers(board.kind) ? kNarrowMargin : kWideMargin);
  low_ = printed_low_ - Eigen::Vector2d::Constant(margin);
  high_ = printed_high_ + Eigen::Vector2d::Constant(margin);
}

BoardPattern::Place BoardPattern::at(double x, double y) const {
  const double on_sheet = within(x, y, low_, high_);
  if (!(on_sheet >= 0.0)) return {Ink::none, -on_sheet};
  const double printed = within(x, y, printed_low_, printed_high_);
  Place out;
  if (printed < 0.0) {
    out = place(false, -printed);
  } else if (board_.kind == BoardKind::aprilgrid) {
    out = tags(x, y);
  } else {
    out = board_.kind == BoardKind::circles ? dots(x, y) : squares(x, y);
  }
  out.clear_m = std::min({out.clear_m, on_sheet, std::abs(printed)});
  return out;
}

BoardPattern::Place BoardPattern::squares(double x, double y) const {
  const double s = board_.size_m;
  const int column = static_cast<int>(std::floor(x / s)) + 1;
  const int row = static_cast<int>(std::floor(y / s)) + 1;
  const double clear_m = std::min(to_line(x, s), to_line(y, s));
  if ((column + row) % 2 == 0) return place(true, clear_m);
  if (board_.kind != BoardKind::charuco) return place(false, clear_m);
  // Markers are numbered through the white squares, row by row.
  const double side = s * board_.ratio;
  const double margin = 0.5 * (s - side);
  const double from_left = x - (column - 1) * s - margin;
  const double from_top = y - (row - 1) * s - margin;
  const double inside = within(from_left, from_top, {0.0, 0.0}, {side, side});
  if (inside < 0.0) return place(false, std::min(clear_m, -inside));
  const int before = row * board_.columns + column;  // squares; of each two that follow each other one is white
  const int id = board_.columns % 2 == 0 ? row * board_.columns / 2 + column / 2 : before / 2;
  Place out = aruco_cell(id, from_left, from_top, side);
  out.clear_m = std::min(out.clear_m, inside);
  return out;
}

BoardPattern::Place BoardPattern::aruco_cell(int id, double x, double y, double side) const {
  const double cell = side / kArucoAcross;
  const int column = std::min(static_cast<int>(x / cell), kArucoAcross - 1);
  const int row = std::min(static_cast<int>(y / cell), kArucoAcross - 1);
  bool black = true;
  if (column > 0 && row > 0 && column < kArucoAcross - 1 && row < kArucoAcross - 1) {
    const int bit = 24 - ((row - 1) * 5 + column - 1);
    black = (kAruco5x5[static_cast<std::size_t>(id)] >> static_cast<unsigned>(bit) & 1U) == 0;
  }
  return place(black, std::min(to_line(x, cell), to_line(y, cell)));
}

// As Kalibr prints it: a small black square where the corners of four tags meet.
BoardPattern::Place BoardPattern::tags(double x, double y) const {
  const double s = board_.size_m;
  const double gap = s * board_.ratio;
  const double step = s + gap;
  const int column = std::clamp(static_cast<int>(std::floor((x + gap) / step)), 0, board_.columns);
  const int row = std::clamp(static_cast<int>(std::floor((y + gap) / step)), 0, board_.rows);
  const double lx = x + gap - column * step, ly = y + gap - row * step;
  const double clear_m = std::min({lx, std::abs(lx - gap), step - lx, ly, std::abs(ly - gap), step - ly});
  const bool gap_x = lx < gap, gap_y = ly < gap;
  if (gap_x || gap_y) return place(gap_x && gap_y, clear_m);
  const double cell = s / kTagAcross;
  const double right = lx - gap, down = s - (ly - gap);  // from the tag's upper left; the board's y points up
  const int across = std::clamp(static_cast<int>(right / cell), 0, kTagAcross - 1) - 2;
  const int below = std::clamp(static_cast<int>(down / cell), 0, kTagAcross - 1) - 2;
  bool black = true;
  if (across >= 0 && below >= 0 && across < 6 && below < 6) {
    const auto id =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(board_.columns) + static_cast<std::size_t>(column);
    black = (kApril36h11[id] >> static_cast<unsigned>(35 - (below * 6 + across)) & 1U) == 0;
  }
  return place(black, std::min({clear_m, to_line(right, cell), to_line(down, cell)}));
}

BoardPattern::Place BoardPattern::dots(double x, double y) const {
  const double s = board_.size_m;
  const double from_edge = std::hypot(to_line(x, s), to_line(y, s)) - kDotRadius * s;
  // Half way to the next dot is farther from that one's edge than from here.
  return place(from_edge < 0.0, std::abs(from_edge));
}

std::vector<Eigen::Vector3d> BoardPattern::outline() const {
  constexpr int kSteps = 4;
  std::vector<Eigen::Vector3d> out;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      if (i % kSteps != 0 && j % kSteps != 0) continue;
      const Eigen::Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps);
      const Eigen::Vector2d p = low_ + share.cwiseProduct(high_ - low_);
      out.emplace_back(p.x(), p.y(), 0.0);
    }
  }
  return out;
}

}  // namespace cliquevo::drivers::sim
