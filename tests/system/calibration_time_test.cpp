// SPDX-License-Identifier: BSD-3-Clause
// What a calibration takes beside OpenCV's, from the same corners, in turns in one process.
#include <algorithm>
#include <cstdio>
#include <ctime>

#include <gtest/gtest.h>

#include "drivers/board_calibration/solve.h"
#include "tests/support/test_data.h"
#include "tests/system/chessboard_views.h"
#include "tests/system/opencv_calibration.h"

namespace cliquevo::test {
namespace {

constexpr int kRounds = 5;

// Of the whole process: OpenCV may use other threads.
template <typename F>
double taken_s(F&& work) {
  const std::clock_t began = std::clock();
  work();
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + kRounds / 2, values.end());
  return values[kRounds / 2];
}

TEST(CalibrationTime, OfOneLensModelIsNoLongerThanStereoCalibrateTakes) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const ChessboardViews seen = chessboard_views();
  calibration::SolveOptions options;
  options.model = "radtan";
  options.held_out = false;
  calibration::SolveOptions everything;
  const auto first = calibration::solve(seen.board, seen.views, seen.width, seen.height, options);
  ASSERT_TRUE(first.ok());
  const std::vector<calibration::View>& views = first->views;  // all counted from the same end
  std::vector<double> ours, all, theirs;
  for (int i = 0; i < kRounds; ++i) {
    ours.push_back(taken_s([&] { (void)calibration::solve(seen.board, views, seen.width, seen.height, options); }));
    all.push_back(taken_s([&] { (void)calibration::solve(seen.board, views, seen.width, seen.height, everything); }));
    theirs.push_back(taken_s([&] { (void)by_opencv(seen.board, views, {seen.width, seen.height}); }));
  }
  std::printf("%.3f s of processor time; with all lens models and views held out %.3f s; OpenCV %.3f s\n", median(ours),
              median(all), median(theirs));
  EXPECT_LE(median(ours), median(theirs));
}

}  // namespace
}  // namespace cliquevo::test
