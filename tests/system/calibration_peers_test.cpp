// SPDX-License-Identifier: BSD-3-Clause
// Others' calibrations from the same corners: mrcal (of Debian's packages, fetched once and not installed) and OpenCV.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "drivers/board_calibration/held_out.h"
#include "drivers/board_calibration/solve.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/chessboard_views.h"
#include "tests/system/opencv_calibration.h"

namespace cliquevo::test {
namespace {

using calibration::kFirstOfPose;
using calibration::kFirstOfRight;
using calibration::Rig;
using calibration::SeenCorner;
using calibration::Side;
using calibration::Solution;
using calibration::View;
using nlohmann::json;

constexpr std::size_t kFolds = 5;  // as hold_out() has them
constexpr int kOfLens = 8;         // fx, fy, cx, cy, k1, k2, p1, p2
constexpr double kFocalGuess_px = 500.0;

Solution ours(const ChessboardViews& seen) {
  calibration::SolveOptions options;
  options.model = "radtan";
  auto solution = calibration::solve(seen.board, seen.views, seen.width, seen.height, options);
  EXPECT_TRUE(solution.ok()) << solution.error().line();
  EXPECT_EQ(solution->views.size(), seen.views.size());
  return std::move(*solution);
}

// Grids of the corners that were used, row by row; null where one was not. All are counted from the same end.
json grids(const ChessboardViews& seen, const Solution& solution) {
  json out = json::array();
  for (const View& view : solution.views) {
    json row;
    for (const Side side : {Side::left, Side::right}) {
      json& grid = row[side == Side::left ? "left" : "right"] = json(seen.board.corner_count(), nullptr);
      for (const SeenCorner& corner : view.of(side)) {
        grid[static_cast<std::size_t>(corner.id)] = {corner.px.x(), corner.px.y()};
      }
    }
    out.push_back(row);
  }
  return out;
}

Rig rig_of(const json& theirs, const Rig& like) {
  Rig rig = like;
  for (const Side side : {Side::left, Side::right}) {
    const json& values = theirs[side == Side::left ? "left" : "right"]["values"];
    for (int i = 0; i < kOfLens; ++i) rig.lens(side)(i) = values[static_cast<std::size_t>(i)];
  }
  for (int i = 0; i < 3; ++i) {
    rig.T_right_left.t(i) = theirs["t"]["values"][static_cast<std::size_t>(i)];
    for (int j = 0; j < 3; ++j) rig.T_right_left.R(i, j) = theirs["R"][static_cast<std::size_t>(3 * i + j)];
  }
  return rig;
}

std::vector<json> by_mrcal(const ChessboardViews& seen, const Solution& solution) {
  json given = {{"size", {seen.width, seen.height}},
                {"board", {seen.board.columns, seen.board.rows, seen.board.size_m}},
                {"focal_px", kFocalGuess_px},
                {"views", grids(seen, solution)},
                {"sets", json::array()}};
  for (std::size_t fold = 0; fold <= kFolds; ++fold) {  // the last is all views
    json kept = json::array();
    for (std::size_t v = 0; v < solution.views.size(); ++v) {
      if (v % kFolds != fold) kept.push_back(v);
    }
    given["sets"].push_back(kept);
  }
  const std::string in = scratch_dir() + "/in.json", out = scratch_dir() + "/out.json";
  std::ofstream(in) << given;
  const Finished done = run({CLIQUEVO_MRCAL_PYTHON, CLIQUEVO_MRCAL_SCRIPT, in, out});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return json::parse(read_file(out));
}

TEST(CalibrationPeers, MrcalFindsTheSameRigAndDoesNoBetterOnViewsHeldOut) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const ChessboardViews seen = chessboard_views();
  const Solution solution = ours(seen);
  const std::vector<json> theirs = by_mrcal(seen, solution);
  ASSERT_EQ(theirs.size(), kFolds + 1);
  const json& all = theirs.back();
  const auto compare = [&](const std::string& name, int index, double value, double error_of_theirs) {
    const double found = index < kFirstOfRight  ? solution.rig().left(index)
                         : index < kFirstOfPose ? solution.rig().right(index - kFirstOfRight)
                                                : solution.rig().T_right_left.t(index - kFirstOfPose);
    const double sigma = std::sqrt(solution.adjusted.covariance(index, index));
    std::printf("%-9s %12.6f +- %.6f, mrcal %12.6f +- %.6f\n", name.c_str(), found, sigma, value, error_of_theirs);
    EXPECT_LE(std::abs(found - value), std::min(sigma, error_of_theirs)) << name;
  };
  for (int i = 0; i < kOfLens; ++i) {
    const auto at = static_cast<std::size_t>(i);
    compare("left " + std::to_string(i), i, all["left"]["values"][at], all["left"]["sigmas"][at]);
    compare("right " + std::to_string(i), kFirstOfRight + i, all["right"]["values"][at], all["right"]["sigmas"][at]);
  }
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    compare("t " + std::to_string(i), kFirstOfPose + i, all["t"]["values"][at], all["t"]["sigmas"][at]);
  }
  double squared = 0.0, count = 0.0;
  for (std::size_t v = 0; v < solution.views.size(); ++v) {
    for (const double rows : row_differences(rig_of(theirs[v % kFolds], solution.rig()), solution.views[v])) {
      squared += rows * rows;
      count += 1.0;
    }
  }
  const double rows_px = std::sqrt(squared / count);
  std::printf("rows of views held out: %.4f px, mrcal %.4f px; sigma of a corner %.4f px, mrcal %.4f px\n",
              solution.held_out.row_rms_px, rows_px, solution.adjusted.sigma_px, all["sigma_px"].get<double>());
  EXPECT_EQ(solution.held_out.corners, static_cast<int>(count));
  EXPECT_LE(solution.held_out.row_rms_px, 1.005 * rows_px);
}

// It takes the board for flat, which this one is not quite: it is farther off than noise alone would have it.
TEST(CalibrationPeers, StereoCalibrateOfOpenCvFindsTheSameRigWithLargerErrors) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const ChessboardViews seen = chessboard_views();
  const Solution solution = ours(seen);
  const OpenCvRig theirs = by_opencv(seen.board, solution.views, {seen.width, seen.height});
  const Rig& rig = solution.rig();
  const auto sigma = [&](int i) { return std::sqrt(solution.adjusted.covariance(i, i)); };
  for (const Side side : {Side::left, Side::right}) {
    const int first = side == Side::left ? 0 : kFirstOfRight;
    const auto& lens = theirs.lenses[static_cast<std::size_t>(side)];
    for (int i = 0; i < kOfLens; ++i) {
      std::printf("%d %d: %.5f +- %.5f, OpenCV %.5f\n", static_cast<int>(side), i, rig.lens(side)(i), sigma(first + i),
                  lens[static_cast<std::size_t>(i)]);
      EXPECT_NEAR(rig.lens(side)(i), lens[static_cast<std::size_t>(i)], 3.0 * sigma(first + i)) << i;
    }
  }
  std::printf("baseline %.6f m, OpenCV %.6f m; error %.4f px, OpenCV %.4f px\n", rig.T_right_left.t.norm(),
              theirs.baseline_m, rms_px(seen.board, solution), theirs.rms_px);
  EXPECT_NEAR(rig.T_right_left.t.norm(), theirs.baseline_m, 3.0 * sigma(kFirstOfPose));
  EXPECT_LE(rms_px(seen.board, solution), theirs.rms_px);
}

}  // namespace
}  // namespace cliquevo::test
