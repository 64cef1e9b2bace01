// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/board.h"

#include <set>

#include <gtest/gtest.h>

namespace cliquevo::calibration {
namespace {

TEST(Board, EachKindHasTheCornersOfItsText) {
  const auto chess = parse_board("chessboard:9x6:0.02423");
  ASSERT_TRUE(chess.ok()) << chess.error().line();
  EXPECT_EQ(chess->corner_count(), 54);
  EXPECT_NEAR((chess->corner(10) - Eigen::Vector3d(0.02423, 0.02423, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(chess->text(), "chessboard:9x6:0.02423");
  const auto charuco = parse_board("charuco:10x7:0.04:0.7");
  ASSERT_TRUE(charuco.ok());
  EXPECT_EQ(charuco->corner_count(), 54);
  EXPECT_EQ(charuco->ratio, 0.7);
  const auto circles = parse_board("circles:7x5:0.03");
  ASSERT_TRUE(circles.ok());
  EXPECT_EQ(circles->corner_count(), 35);
}

TEST(Board, AnAprilgridIsKalibrs) {
  const auto grid = parse_board("aprilgrid:6x6:0.088:0.3");
  ASSERT_TRUE(grid.ok()) << grid.error().line();
  EXPECT_EQ(grid->corner_count(), 144);
  // Tag 0 at the lower left, its corners counter-clockwise; tag 1 beside it; tag 6 above it.
  EXPECT_NEAR((grid->corner(2) - Eigen::Vector3d(0.088, 0.088, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((grid->corner(4) - Eigen::Vector3d(1.3 * 0.088, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((grid->corner(24) - Eigen::Vector3d(0.0, 1.3 * 0.088, 0.0)).norm(), 0.0, 1e-12);
  std::set<std::pair<double, double>> places;
  for (int id = 0; id < grid->corner_count(); ++id) places.insert({grid->corner(id).x(), grid->corner(id).y()});
  EXPECT_EQ(places.size(), 144U) << "no two corners in one place";
}

TEST(Board, WhatIsNoBoardIsRefusedWithWhatToWrite) {
  for (const char* text : {"", "chess:9x6:0.02", "chessboard", "chessboard:9x6", "chessboard:9x6:", "chessboard:9:0.02",
                           "chessboard:9x6:0.02:3", "chessboard:2x6:0.02", "chessboard:9x6:24.23", "chessboard:9x6:nan",
                           "chessboard:9x6:-1", "charuco:9x6:0.03:1.5", "aprilgrid:99999x9:0.08", "circles:9x-6:0.1"}) {
    const auto board = parse_board(text);
    ASSERT_FALSE(board.ok()) << text;
    EXPECT_GT(board.error().remedy.size(), 10U) << board.error().line();
  }
  EXPECT_NE(parse_board("chessboard:9x6").error().line().find("measure"), std::string::npos)
      << "the size of squares can be seen in no image";
}

}  // namespace
}  // namespace cliquevo::calibration
