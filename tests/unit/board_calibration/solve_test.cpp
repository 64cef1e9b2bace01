// SPDX-License-Identifier: BSD-3-Clause
// Calibrations of random rigs against exact truth.
#include "drivers/board_calibration/solve.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "drivers/board_calibration/held_out.h"
#include "tests/unit/board_calibration/made_rig.h"

namespace cliquevo::calibration {
namespace {

constexpr double kNoise_px = 0.1;

Eigen::Matrix<double, kShared, 1> error_of(const Rig& found, const Rig& truth) {
  Eigen::Matrix<double, kShared, 1> error;
  error << found.left - truth.left, found.right - truth.right, left_difference(truth.T_right_left, found.T_right_left),
      found.bend_m - truth.bend_m;
  return error;
}

TEST(Solve, OfTwentyRandomRigsParametersLieWithinThreeOfTheirSigmas) {
  int within = 0;
  int count = 0;
  double squared = 0.0;
  for (std::uint64_t seed = 0; seed < kRigs; ++seed) {
    const MadeRig made = make_rig(seed, 30, kNoise_px);
    SolveOptions options;
    options.model = made.rig.model->name;
    const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
    ASSERT_TRUE(solution.ok()) << seed << " " << solution.error().line();
    EXPECT_NEAR(solution->adjusted.sigma_px, kNoise_px, 0.1 * kNoise_px) << seed;
    const auto error = error_of(solution->rig(), made.rig);
    for (int i = 0; i < kShared; ++i) {
      const double variance = solution->adjusted.covariance(i, i);
      if (!(variance > 0.0)) continue;
      ++count;
      within += error(i) * error(i) <= 9.0 * variance ? 1 : 0;
      squared += error(i) * error(i) / variance;
    }
    double rows = 0.0;
    double places = 0.0;
    for (const View& view : made.exact) {
      for (const double difference : row_differences(solution->rig(), view)) {
        rows += difference * difference;
        places += 1.0;
      }
    }
    ASSERT_GT(places, 100.0);
    EXPECT_LE(std::sqrt(rows / places), 0.05) << "epipolar error of exact corners, rig " << seed;
  }
  EXPECT_GE(within, 0.97 * count);
  EXPECT_NEAR(squared / count, 1.0, kRigs == 20 ? 0.35 : 0.8) << "normalised error";
}

TEST(Solve, FourTimesTheViewsHalveTheSigmas) {
  double logs = 0.0;
  int count = 0;
  for (const std::uint64_t seed : {0, 1, 4, 5}) {
    if (seed > 0 && kRigs < 20) continue;
    SolveOptions options;
    options.model = "radtan";
    const MadeRig few = make_rig(seed, 20, kNoise_px);
    const MadeRig many = make_rig(seed, 80, kNoise_px);
    const auto of_few = solve(few.board, few.views, few.rig.width, few.rig.height, options);
    const auto of_many = solve(many.board, many.views, many.rig.width, many.rig.height, options);
    ASSERT_TRUE(of_few.ok() && of_many.ok());
    for (int i = 0; i < kFirstOfBend; ++i) {
      const double ratio = of_few->adjusted.covariance(i, i) / of_many->adjusted.covariance(i, i);
      if (!std::isfinite(ratio) || !(ratio > 0.0)) continue;
      logs += 0.5 * std::log(ratio);
      ++count;
    }
  }
  EXPECT_NEAR(std::exp(logs / count), 2.0, kRigs == 20 ? 0.3 : 0.6) << "over all parameters";
}

TEST(Solve, AutoFindsTheLensThatExplainsViewsHeldOut) {
  for (const std::uint64_t seed : {0, 3}) {
    if (seed > 0 && kRigs < 20) continue;
    const MadeRig made = make_rig(seed, 25, kNoise_px);
    const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, {});
    ASSERT_TRUE(solution.ok()) << solution.error().line();
    EXPECT_STREQ(solution->rig().model->name, made.rig.model->name);
    EXPECT_GE(solution->tried.size(), 2U);
    EXPECT_NEAR(solution->held_out.reprojection_rms_px, kNoise_px, 0.15 * kNoise_px);
  }
}

TEST(Solve, WrongCornersAreLeftOutAndNamed) {
  MadeRig made = make_rig(4, 20, kNoise_px);
  made.views[3].left[5].px.x() += 4.0;
  made.views[7].right[2].px.y() -= 2.5;
  SolveOptions options;
  options.model = made.rig.model->name;
  const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
  ASSERT_TRUE(solution.ok()) << solution.error().line();
  ASSERT_EQ(solution->dropped_corners.size(), 2U);
  EXPECT_EQ(solution->dropped_corners[0].view, "view 3");
  EXPECT_EQ(solution->dropped_corners[0].id, made.views[3].left[5].id);
  EXPECT_NEAR(solution->dropped_corners[1].error_px, 2.5, 0.5);
  EXPECT_LT((error_of(solution->rig(), made.rig)).head<4>().norm(), 1.0);
}

TEST(Solve, AViewOfAnotherMomentInEachCameraIsDroppedByName) {
  MadeRig made = make_rig(5, 20, kNoise_px);
  std::swap(made.views[2].right, made.views[9].right);
  SolveOptions options;
  options.model = made.rig.model->name;
  const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
  ASSERT_TRUE(solution.ok()) << solution.error().line();
  EXPECT_EQ(solution->dropped_views, (std::vector<std::string>{"view 2", "view 9"}));
}

TEST(Solve, AChessboardCountedFromTheOtherEndInOneImageIsTheSameBoard) {
  MadeRig made = make_rig(1, 20, kNoise_px);
  made.board.kind = BoardKind::chessboard;
  made.board.columns = 9;
  made.board.rows = 6;
  made.board.ratio = 0.0;
  for (std::size_t v = 0; v < made.views.size(); v += 3) {
    for (SeenCorner& corner : made.views[v].right) corner.id = made.board.corner_count() - 1 - corner.id;
  }
  SolveOptions options;
  options.model = "radtan";
  const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
  ASSERT_TRUE(solution.ok()) << solution.error().line();
  EXPECT_TRUE(solution->dropped_views.empty());
  EXPECT_NEAR(solution->rig().T_right_left.t.norm(), made.rig.T_right_left.t.norm(), 1e-3);
}

TEST(Solve, ABentBoardIsNoticedAndDoesNotBendTheLens) {
  MadeRig made = make_rig(0, 40, 0.0);
  const Eigen::Vector2d bend_m = 0.004 * made.board.half_extent();
  for (std::size_t v = 0; v < made.views.size(); ++v) {
    for (const Side side : {Side::left, Side::right}) {
      for (SeenCorner& corner : made.views[v].of(side)) {
        Eigen::Vector3d p = made.T_left_board[v] * bent_corner(made.board, corner.id, bend_m).at;
        if (side == Side::right) p = made.rig.T_right_left * p;
        corner.px = project_with_derivatives(*made.rig.model, made.rig.lens(side), p).px;
      }
    }
  }
  SolveOptions options;
  options.model = made.rig.model->name;
  const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, options);
  ASSERT_TRUE(solution.ok()) << solution.error().line();
  EXPECT_NEAR(solution->rig().bend_m.x(), bend_m.x(), 0.05 * bend_m.x());
  EXPECT_NEAR(solution->rig().left(0), made.rig.left(0), 0.05);
}

TEST(Solve, WhatCannotBeCalibratedSaysWhy) {
  const MadeRig made = make_rig(0, 12, kNoise_px);
  const auto refused = [&](std::vector<View> views, const std::vector<std::string>& words) {
    const auto solution = solve(made.board, std::move(views), made.rig.width, made.rig.height, {});
    ASSERT_FALSE(solution.ok());
    for (const std::string& word : words) {
      EXPECT_NE(solution.error().line().find(word), std::string::npos) << solution.error().line();
    }
  };
  refused({made.views.begin(), made.views.begin() + 3}, {"too few views"});
  std::vector<View> one_camera = made.views;
  for (View& view : one_camera) view.right.clear();
  refused(one_camera, {"right camera never saw the board"});
  std::vector<View> exchanged = made.views;
  for (View& view : exchanged) std::swap(view.left, view.right);
  refused(exchanged, {"exchanged", "--swap-eyes"});
  refused({}, {"never saw"});
}

TEST(Solve, ViewsThatAreAllParallelAreRefused) {
  MadeRig made = make_rig(0, 12, 0.02);
  for (std::size_t v = 0; v < made.views.size(); ++v) {
    RigidTransform T;
    T.t = Eigen::Vector3d(-0.5 * static_cast<double>(v % 3), -0.3, 1.2 + 0.1 * static_cast<double>(v)) *
          made.board.half_extent().x() * 2.0;
    for (const Side side : {Side::left, Side::right}) {
      made.views[v].of(side).clear();
      for (int id = 0; id < made.board.corner_count(); ++id) {
        Eigen::Vector3d p = T * made.board.corner(id);
        if (side == Side::right) p = made.rig.T_right_left * p;
        made.views[v].of(side).push_back({id, project_with_derivatives(*made.rig.model, made.rig.lens(side), p).px});
      }
    }
  }
  const auto solution = solve(made.board, made.views, made.rig.width, made.rig.height, {});
  ASSERT_FALSE(solution.ok());
  EXPECT_NE(solution.error().line().find("parallel"), std::string::npos) << solution.error().line();
}

}  // namespace
}  // namespace cliquevo::calibration
