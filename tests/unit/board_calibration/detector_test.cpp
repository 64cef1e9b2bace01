// SPDX-License-Identifier: BSD-3-Clause
// Boards drawn as a camera sees them: corners are found where the drawing has them.
#include "tools/calibrate/detector.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/base/image.h"
#include "tools/calibrate/markers.h"

namespace cliquevo::tools {
namespace {

using calibration::Board;
using calibration::BoardKind;
using calibration::SeenCorner;

constexpr double kPxOfMetre = 2000.0;  // of the flat drawing
constexpr int kMargin_px = 60;

// The board flat, its frame's origin at (origin) px; y as the board has it.
struct Drawing {
  cv::Mat image;
  cv::Point2d origin;
  double down = 1.0;  // of the board's y
  cv::Point2d at(const Eigen::Vector3d& p) const {
    return {origin.x + kPxOfMetre * p.x(), origin.y + down * kPxOfMetre * p.y()};
  }
};

void fill(cv::Mat& image, double x, double y, double side, int grey) {
  const auto round = [](double v) { return static_cast<int>(std::lround(v)); };
  cv::rectangle(image, cv::Rect(round(x), round(y), round(x + side) - round(x), round(y + side) - round(y)), grey,
                cv::FILLED);
}

void put_cells(cv::Mat& image, double x, double y, double side, const MarkerCells& cells) {
  const double cell = side / cells.across;
  for (int row = 0; row < cells.across; ++row) {
    for (int column = 0; column < cells.across; ++column) {
      if (cells.black(column, row)) fill(image, x + column * cell, y + row * cell, cell, 20);
    }
  }
}

// Pixel edges lie at whole numbers; OpenCV's coordinates count from the first pixel's centre: half a pixel less.
Drawing draw(const Board& b) {
  Drawing out;
  const double s = kPxOfMetre * b.size_m;
  const bool grid = b.kind == BoardKind::aprilgrid;
  const int across = b.kind == BoardKind::chessboard ? b.columns + 1 : b.columns;
  const int down = b.kind == BoardKind::chessboard ? b.rows + 1 : b.rows;
  const double step = grid ? s * (1.0 + b.ratio) : s;
  out.image = cv::Mat(static_cast<int>(down * step + (grid ? s * b.ratio : 0.0)) + 2 * kMargin_px,
                      static_cast<int>(across * step + (grid ? s * b.ratio : 0.0)) + 2 * kMargin_px, CV_8U, 220);
  const double m = kMargin_px;
  if (grid) {
    const double gap = s * b.ratio;
    for (int row = 0; row <= b.rows; ++row) {
      for (int column = 0; column <= b.columns; ++column) fill(out.image, m + column * step, m + row * step, gap, 20);
    }
    const double height = b.rows * step + gap;
    for (int id = 0; id < b.columns * b.rows; ++id) {
      put_cells(out.image, m + gap + (id % b.columns) * step, m + height - gap - s - (id / b.columns) * step, s,
                april_tag(id));
    }
    out.origin = {m + gap - 0.5, m + height - gap - 0.5};
    out.down = -1.0;
    return out;
  }
  if (b.kind == BoardKind::circles) {
    for (int row = 0; row < b.rows; ++row) {
      for (int column = 0; column < b.columns; ++column) {
        cv::circle(out.image, cv::Point2d(m + (column + 0.5) * s, m + (row + 0.5) * s), static_cast<int>(0.25 * s), 20,
                   cv::FILLED, cv::LINE_AA);
      }
    }
    out.origin = {m + 0.5 * s, m + 0.5 * s};
    return out;
  }
  int id = 0;
  for (int row = 0; row < down; ++row) {
    for (int column = 0; column < across; ++column) {
      if ((row + column) % 2 == 0) {
        fill(out.image, m + column * s, m + row * s, s, 20);
      } else if (b.kind == BoardKind::charuco) {
        const double side = s * b.ratio;
        put_cells(out.image, m + column * s + 0.5 * (s - side), m + row * s + 0.5 * (s - side), side,
                  aruco_marker(b, id++));
      }
    }
  }
  out.origin = {m + s - 0.5, m + s - 0.5};
  return out;
}

struct Look {
  Image<std::uint8_t> image;
  cv::Mat H;
};

// From the side, a little blurred, with noise.
Look look_at(const Drawing& drawing, bool mirrored = false) {
  Look out;
  const double scale = std::min(1100.0 / drawing.image.cols, 800.0 / drawing.image.rows);
  out.H = (cv::Mat_<double>(3, 3) << scale, 0.08 * scale, 60.0, -0.05 * scale, 0.95 * scale, 90.0, 6e-5 * scale,
           4e-5 * scale, 1.0);
  cv::Mat view;
  cv::warpPerspective(drawing.image, view, out.H, {1280, 960}, cv::INTER_AREA, cv::BORDER_CONSTANT, 200);
  cv::GaussianBlur(view, view, {}, 0.8);
  cv::Mat noise(view.size(), CV_16S), sum;
  cv::RNG random(7);
  random.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(view, noise, sum, {}, CV_8U);
  if (mirrored) cv::flip(sum, sum, 1);
  out.image.copy_from(ImageView<const std::uint8_t>{sum.data, sum.cols, sum.rows, static_cast<int>(sum.step)});
  return out;
}

double rms_error(const Drawing& drawing, const Look& look, const Board& board, const std::vector<SeenCorner>& found) {
  double best = 1e9;
  // A chessboard and a grid of dots may be counted from the other end.
  for (const bool turned : {false, true}) {
    double squared = 0.0;
    for (const SeenCorner& c : found) {
      const int id = turned ? board.corner_count() - 1 - c.id : c.id;
      std::vector<cv::Point2d> at{drawing.at(board.corner(id))}, to;
      cv::perspectiveTransform(at, to, look.H);
      squared += (c.px - Eigen::Vector2d(to[0].x, to[0].y)).squaredNorm();
    }
    best = std::min(best, std::sqrt(squared / static_cast<double>(found.size())));
  }
  return best;
}

TEST(BoardDetector, FindsEveryKindWhereItIs) {
  const std::vector<std::pair<Board, double>> boards{{{BoardKind::chessboard, 9, 6, 0.03, 0.0}, 0.1},
                                                     {{BoardKind::charuco, 9, 7, 0.03, 0.75}, 0.15},
                                                     {{BoardKind::aprilgrid, 4, 3, 0.06, 0.3}, 0.2},
                                                     {{BoardKind::circles, 7, 5, 0.03, 0.0}, 0.3}};
  for (const auto& [board, most_px] : boards) {
    const Drawing drawing = draw(board);
    const Look look = look_at(drawing);
    const auto found = BoardDetector(board).find(look.image.cview());
    ASSERT_EQ(static_cast<int>(found.size()), board.corner_count()) << board.text();
    EXPECT_LT(rms_error(drawing, look, board, found), most_px) << board.text();
  }
}

TEST(BoardDetector, BoardsWithMarkersAreFoundInPart) {
  for (const Board& board :
       {Board{BoardKind::charuco, 9, 7, 0.03, 0.75}, Board{BoardKind::aprilgrid, 4, 3, 0.06, 0.3}}) {
    Drawing drawing = draw(board);
    drawing.image.colRange(0, drawing.image.cols / 2).setTo(220);
    const Look look = look_at(drawing);
    const auto found = BoardDetector(board).find(look.image.cview());
    EXPECT_GE(static_cast<int>(found.size()), board.corner_count() / 4) << board.text();
    EXPECT_LT(static_cast<int>(found.size()), board.corner_count()) << board.text();
    EXPECT_LT(rms_error(drawing, look, board, found), 0.3) << board.text();
  }
}

TEST(BoardDetector, SaysWhatIsSeenInstead) {
  const Look smaller = look_at(draw({BoardKind::chessboard, 8, 5, 0.03, 0.0}));
  const BoardDetector chess({BoardKind::chessboard, 9, 6, 0.03, 0.0});
  EXPECT_TRUE(chess.find(smaller.image.cview()).empty());
  EXPECT_EQ(chess.nearest_guess(smaller.image.cview()), "8x5 corners are seen, 9x6 were named");

  const Board charuco{BoardKind::charuco, 9, 7, 0.03, 0.75};
  const Look mirrored = look_at(draw(charuco), true);
  EXPECT_TRUE(BoardDetector(charuco).find(mirrored.image.cview()).empty());
  EXPECT_NE(BoardDetector(charuco).nearest_guess(mirrored.image.cview()).find("mirror"), std::string::npos);

  Image<std::uint8_t> grey(320, 240);
  for (int y = 0; y < 240; ++y) std::fill_n(grey.view().row(y), 320, std::uint8_t{128});
  EXPECT_EQ(chess.nearest_guess(grey.cview()), "");
}

}  // namespace
}  // namespace cliquevo::tools
