// SPDX-License-Identifier: BSD-3-Clause
#include "tools/chart.h"

#include <gtest/gtest.h>

namespace cliquevo::tools {
namespace {

TEST(Chart, TicksAreRoundNumbersInsideTheRange) {
  EXPECT_EQ(tick_positions(0.0, 100.0, 5), (std::vector<double>{0, 20, 40, 60, 80, 100}));
  const auto fine = tick_positions(-0.13, 0.27, 4);
  ASSERT_EQ(fine.size(), 4u);
  EXPECT_NEAR(fine.front(), -0.1, 1e-12);
  EXPECT_NEAR(fine.back(), 0.2, 1e-12);
}

TEST(Chart, AnEmptyOrImpossibleRangeHasNoTicks) {
  EXPECT_TRUE(tick_positions(1.0, 1.0, 5).empty());
  EXPECT_TRUE(tick_positions(0.0, std::numeric_limits<double>::infinity(), 5).empty());
}

TEST(Chart, APictureIsDrawnInTheColourOfItsLine) {
  Figure figure(300, 200);
  const cv::Scalar red(0, 0, 255);
  figure.draw({"", "", "", false, false, {{"", {{0, 0}, {1, 1}}, red, 4.0, Mark::none, 0.0, false}}}, {0, 0, 300, 200});
  const cv::Mat picture = figure.render();
  ASSERT_EQ(picture.size(), cv::Size(300, 200));
  cv::Mat is_red;
  cv::inRange(picture, cv::Scalar(0, 0, 200), cv::Scalar(60, 60, 255), is_red);
  EXPECT_GT(cv::countNonZero(is_red), 200);
}

TEST(Chart, DataWithoutExtentIsStillAPicture) {
  Figure figure(300, 200);
  figure.draw({"t", "x", "y", true, false, {{"p", {{2, 2}}, {0, 0, 0}, 2.0, Mark::disc, 4.0, true}}}, {0, 0, 300, 200});
  figure.draw({"t", "x", "y", false, true, {}}, {0, 0, 300, 200});
  EXPECT_FALSE(figure.render().empty());
}

}  // namespace
}  // namespace cliquevo::tools
