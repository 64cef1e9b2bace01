// SPDX-License-Identifier: BSD-3-Clause
// Boards that the simulator moves before known lenses: corners are found where they are, and calibrating gives the rig.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "drivers/board_calibration/solve.h"
#include "drivers/simulator.h"
#include "drivers/simulator/board_rig.h"
#include "drivers/simulator/board_source.h"
#include "drivers/simulator/marker_tables.h"
#include "tools/calibrate/collect.h"
#include "tools/calibrate/detector.h"
#include "tools/calibrate/markers.h"

namespace cliquevo::tools {
namespace {

using calibration::Board;
using calibration::SeenCorner;
using calibration::Side;
using drivers::sim::BoardSimulator;
using drivers::sim::SimulatedLens;

std::unique_ptr<drivers::Simulator> open(const std::string& options) {
  const auto parsed = drivers::parse_simulator_options(options);
  EXPECT_TRUE(parsed.ok()) << parsed.error().line();
  auto source = drivers::open_simulator(*parsed);
  EXPECT_TRUE(source.ok()) << source.error().line();
  return std::move(*source);
}

TEST(SimulatedBoard, ItsMarkersAreThoseOfTheLibraries) {
  const Board charuco{calibration::BoardKind::charuco, 14, 14, 0.03, 0.75};
  for (int id = 0; id < 98; ++id) {
    const MarkerCells aruco = aruco_marker(charuco, id);
    const MarkerCells tag = april_tag(id);
    const auto place = static_cast<std::size_t>(id);
    for (int i = 0; i < 25; ++i) {
      const bool white = (drivers::sim::kAruco5x5[place] >> static_cast<unsigned>(24 - i) & 1U) != 0;
      ASSERT_EQ(aruco.black(1 + i % 5, 1 + i / 5), !white) << id << " " << i;
    }
    for (int i = 0; i < 36; ++i) {
      const bool white = (drivers::sim::kApril36h11[place] >> static_cast<unsigned>(35 - i) & 1U) != 0;
      ASSERT_EQ(tag.black(2 + i % 6, 2 + i / 6), !white) << id << " " << i;
    }
  }
}

// Of one side's corners against the truth, whichever way round the board is counted; px.
struct Errors {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squared = 0.0;
  double count = 0.0;
  double outliers = 0.0;  // farther off than a pixel: the solver names them
};
Errors errors_of(const Board& board, const std::vector<SeenCorner>& found, const SimulatedLens& lens,
                 const RigidTransform& T_camera_board) {
  Errors best;
  best.outliers = 1e9;
  for (const bool turned : {false, true}) {
    Errors e;
    for (const SeenCorner& c : found) {
      const int id = turned ? board.corner_count() - 1 - c.id : c.id;
      const auto px = lens.project(T_camera_board * board.corner(id));
      const Eigen::Vector2d error = px ? Eigen::Vector2d(c.px - *px) : Eigen::Vector2d::Constant(100.0);
      if (error.norm() > 1.0) {
        e.outliers += 1.0;
        continue;
      }
      e.sum += error;
      e.squared += error.squaredNorm();
      e.count += 1.0;
    }
    if (e.outliers < best.outliers) best = e;
  }
  return best;
}

TEST(SimulatedBoard, CornersOfEveryKindThroughEveryLensAreFoundWhereTheyAre) {
  struct Row {
    const char* board;
    const char* lens;
    const char* more;
    double most_px;
  };
  const Row rows[] = {
      {"chessboard:9x6:0.03", "none", "focal_px=560", 0.02},
      {"chessboard:9x6:0.03", "plumb_bob", "focal_px=560,rig_seed=3", 0.02},
      {"chessboard:9x6:0.03", "rational", "focal_px=400", 0.02},
      {"chessboard:9x6:0.03", "equidistant", "focal_px=200,baseline_m=0.06", 0.04},
      {"charuco:9x7:0.03", "plumb_bob", "focal_px=560", 0.02},
      {"aprilgrid:4x3:0.06", "plumb_bob", "focal_px=560", 0.02},
      {"circles:7x5:0.04", "none", "focal_px=560", 0.35},
  };
  for (const Row& row : rows) {
    const auto source = open(
        fmt::format("board={},lens={},{},board_hold_s=0,frames=8,width=640,height=480", row.board, row.lens, row.more));
    const auto* truth = dynamic_cast<const BoardSimulator*>(source.get());
    ASSERT_NE(truth, nullptr);
    const Board board = *calibration::parse_board(row.board);
    const BoardDetector detector(board);
    const SimulatedLens left(source->info().calibration.left), right(source->info().calibration.right);
    drivers::StereoPair pair;
    Errors all;
    int views = 0;
    while (*source->next(pair)) {
      for (const bool is_left : {true, false}) {
        const auto found = detector.find((is_left ? pair.left : pair.right).cview());
        if (found.empty()) continue;
        const RigidTransform T = is_left ? truth->truth_T_left_board() : truth->truth_T_right_board();
        const Errors e = errors_of(board, found, is_left ? left : right, T);
        all.sum += e.sum;
        all.squared += e.squared;
        all.count += e.count;
        all.outliers += e.outliers;
        ++views;
      }
    }
    EXPECT_GE(views, 10) << row.board << " " << row.lens;
    const double mean = all.sum.norm() / all.count, rms = std::sqrt(all.squared / all.count);
    std::printf("%s %s: %d views, %.0f corners, mean error %.4f px, RMS %.4f px, %.0f outliers\n", row.board, row.lens,
                views, all.count, mean, rms, all.outliers);
    EXPECT_LT(rms, row.most_px) << row.board << " " << row.lens;
    EXPECT_LT(mean, 0.02) << row.board << " " << row.lens;
    EXPECT_LE(all.outliers, 0.02 * all.count) << row.board << " " << row.lens;
  }
}

TEST(SimulatedBoard, CalibratingFindsTheRigWithinThreeOfItsSigmas) {
  struct Row {
    const char* model;
    const char* options;
  };
  const Row rows[] = {
      {"radtan", "lens=plumb_bob,focal_px=560,rig_seed=1"},
      {"radtan", "lens=plumb_bob,focal_px=480,rig_seed=2,defocus_px=0.7"},
      {"equidistant", "lens=equidistant,focal_px=210,baseline_m=0.06,rig_seed=3"},
      {"rational", "lens=rational,focal_px=420,rig_seed=4"},
  };
  int within = 0, count = 0;
  double squared = 0.0;
  for (const Row& row : rows) {
    const std::string text = "chessboard:9x6:0.03";
    const auto source =
        open(fmt::format("board={},{},board_hold_s=0,frames=40,width=640,height=480", text, row.options));
    const StereoCalibration& truth = source->info().calibration;
    const Board board = *calibration::parse_board(text);
    const auto collected = collect_views(*source, board, {.news_of_width = 0.0});
    ASSERT_TRUE(collected.ok());
    calibration::SolveOptions options;
    options.model = row.model;
    const auto solution = calibration::solve(board, collected->views, 640, 480, options);
    ASSERT_TRUE(solution.ok()) << solution.error().line();
    const calibration::Rig& rig = solution->rig();
    const auto put = [&](int index, double error) {
      const double variance = solution->adjusted.covariance(index, index);
      if (!(variance > 0.0)) return;
      ++count;
      within += error * error <= 9.0 * variance ? 1 : 0;
      squared += error * error / variance;
      if (error * error > 9.0 * variance) {
        std::printf("  %s is off by %.1f sigmas\n", calibration::shared_name(rig, index).c_str(),
                    error / std::sqrt(variance));
      }
    };
    for (const Side side : {Side::left, Side::right}) {
      const CameraCalibration& c = side == Side::left ? truth.left : truth.right;
      const CameraCalibration found = calibration::to_camera(*rig.model, rig.lens(side), 640, 480);
      const int first = side == Side::left ? 0 : calibration::kFirstOfRight;
      put(first, found.fx_px - c.fx_px);
      put(first + 1, found.fy_px - c.fy_px);
      put(first + 2, found.cx_px - c.cx_px);
      put(first + 3, found.cy_px - c.cy_px);
      for (int i = 0; i < rig.model->coefficients; ++i) {
        const auto at = static_cast<std::size_t>(rig.model->places[static_cast<std::size_t>(i)]);
        put(first + 4 + i, found.coefficients[at] - c.coefficients[at]);
      }
    }
    const auto error = left_difference(truth.T_right_left, rig.T_right_left);
    for (int i = 0; i < 6; ++i) put(calibration::kFirstOfPose + i, error(i));
    std::printf("%s: sigma %.3f px, baseline %.5f m of %.5f, rotation off by %.4f deg\n", row.options,
                solution->adjusted.sigma_px, rig.T_right_left.t.norm(), truth.T_right_left.t.norm(),
                180.0 / M_PI * (truth.T_right_left.inverse() * rig.T_right_left).angle());
  }
  std::printf("%d of %d parameters within three sigmas, normalised error %.2f\n", within, count, squared / count);
  EXPECT_GE(within, 0.97 * count);
  EXPECT_LT(squared / count, 2.0);
}

// A board that moves is seen elsewhere by a right camera that exposes later.
TEST(SimulatedBoard, TheRightCameraMayExposeLater) {
  const auto source =
      open("board=chessboard:9x6:0.03,frames=20,rate_hz=10,skew_ms=20,board_hold_s=0.3,board_move_s=0.7");
  const auto* truth = dynamic_cast<const BoardSimulator*>(source.get());
  const RigidTransform T_right_left = source->info().calibration.T_right_left;
  drivers::StereoPair pair;
  double most_m = 0.0;
  while (*source->next(pair)) {
    EXPECT_EQ(pair.right_offset_ns, 20'000'000);
    const RigidTransform together = T_right_left * truth->truth_T_left_board();
    most_m = std::max(most_m, (together.t - truth->truth_T_right_board().t).norm());
  }
  EXPECT_GT(most_m, 0.002);
}

TEST(SimulatedBoard, WhatMovesBeforeCamerasThatDoNotExposeTogetherIsLeftOut) {
  const std::string text = "chessboard:9x6:0.03";
  const Board board = *calibration::parse_board(text);
  const auto calibrated = [&](double most_speed_px_s) {
    const auto source = open("board=" + text + ",raw=on,frames=240,rate_hz=15,every=1,skew_ms=8,board_hold_s=0.3");
    const auto collected = collect_views(*source, board, {.most_speed_px_s = most_speed_px_s});
    EXPECT_TRUE(collected.ok());
    calibration::SolveOptions options;
    options.model = "radtan";
    auto solution = calibration::solve(board, collected->views, 512, 384, options);
    EXPECT_TRUE(solution.ok());
    std::printf("%zu views, %d moving: sigma %.3f px, baseline %.5f m, %zu dropped\n", collected->views.size(),
                static_cast<int>(collected->moving), solution->adjusted.sigma_px, solution->rig().T_right_left.t.norm(),
                solution->dropped_views.size());
    return std::pair{*collected, *solution};
  };
  const auto [still, of_still] = calibrated(30.0);
  EXPECT_GT(still.moving, 60);
  EXPECT_GE(still.views.size(), 12U);
  EXPECT_LT(of_still.adjusted.sigma_px, 0.02);
  EXPECT_TRUE(of_still.dropped_views.empty());
  EXPECT_NEAR(of_still.rig().T_right_left.t.norm(), 0.12, 2e-4);
}

}  // namespace
}  // namespace cliquevo::tools
