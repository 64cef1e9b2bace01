// SPDX-License-Identifier: BSD-3-Clause
#include "tools/chart.h"

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

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
  const Color red{255, 0, 0};
  figure.draw({"", "", "", false, false, {{"", {{0, 0}, {1, 1}}, red, 4.0, Mark::none, 0.0, false}}}, {0, 0, 300, 200});
  const Picture picture = figure.render();
  ASSERT_EQ(picture.width(), 300);
  ASSERT_EQ(picture.height(), 200);
  int found = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 300; ++x) {
      const Color c = picture.at(x, y);
      found += c.red >= 200 && c.green <= 60 && c.blue <= 60 ? 1 : 0;
    }
  }
  EXPECT_GT(found, 200);
}

TEST(Chart, DataWithoutExtentIsStillAPicture) {
  Figure figure(300, 200);
  figure.draw({"t", "x", "y", true, false, {{"p", {{2, 2}}, Color{0, 0, 0}, 2.0, Mark::disc, 4.0, true}}},
              {0, 0, 300, 200});
  figure.draw({"t", "x", "y", false, true, {}}, {0, 0, 300, 200});
  EXPECT_FALSE(figure.render().empty());
}

int dark_pixels(const Picture& picture, Box box) {
  int found = 0;
  for (int y = static_cast<int>(box.y); y < box.bottom(); ++y) {
    for (int x = static_cast<int>(box.x); x < box.right(); ++x) found += picture.at(x, y).red < 128 ? 1 : 0;
  }
  return found;
}

TEST(Canvas, TextStandsWhereItWasPutAndIsAsWideAsTold) {
  const std::string text = "Trajectory 0123456789 (m)";
  const double width = text_width(text, 14.0);
  Canvas canvas(400, 60);
  canvas.text(text, {20, 30}, 14.0, {0, 0, 0});
  const Picture picture = canvas.finish();
  EXPECT_GT(dark_pixels(picture, {0, 0, 400, 60}), 300);
  EXPECT_EQ(dark_pixels(picture, {0, 0, 18, 60}), 0);
  EXPECT_EQ(dark_pixels(picture, {20 + width + 2, 0, 400 - 22 - width, 60}), 0);
  EXPECT_GT(dark_pixels(picture, {20 + width - 8, 0, 10, 60}), 0);
  EXPECT_EQ(dark_pixels(picture, {0, 0, 400, 20}), 0);  // no higher than capitals and brackets
  Canvas upright(60, 400);
  upright.text(text, {30, 380}, 14.0, {0, 0, 0}, true);
  EXPECT_NEAR(dark_pixels(upright.finish(), {0, 0, 60, 400}), dark_pixels(picture, {0, 0, 400, 60}), 40);
}

TEST(Canvas, EveryPrintableCharacterLeavesInkOfItsOwn) {
  std::set<std::vector<int>> seen;
  for (char c = '!'; c <= '~'; ++c) {
    Canvas canvas(40, 40);
    canvas.text(std::string(1, c), {10, 20}, 20.0, {0, 0, 0});
    const Picture picture = canvas.finish();
    std::vector<int> pixels;
    for (int i = 0; i < 1600; ++i) pixels.push_back(picture.at(i % 40, i / 40).red);
    EXPECT_GT(dark_pixels(picture, {0, 0, 40, 40}), 3) << c;
    EXPECT_TRUE(seen.insert(pixels).second) << c;
  }
  EXPECT_EQ(text_width("\xff", 10.0), text_width("?", 10.0));
}

TEST(Canvas, WhatLiesOutsideOrNowhereIsLeftOut) {
  Canvas canvas(20, 20);
  canvas.line({-1e9, -1e9}, {1e9, 1e9}, 2.0, {0, 0, 0});
  canvas.line({0, 0}, {std::nan(""), 1}, 2.0, {0, 0, 0});
  canvas.disc({-100, 5}, 3, {0, 0, 0});
  canvas.fill({-5, -5, 1000, 6}, {0, 0, 0});
  EXPECT_EQ(canvas.finish().at(10, 0).red, 0);
  EXPECT_EQ(canvas.finish().at(10, 10).red, 0);
  EXPECT_EQ(canvas.finish().at(15, 5).red, 255);
}

// The polynomials miss the table by a shade, at its dark end by more.
TEST(Picture, TheRainbowIsWithinAShadeOfOpenCVs) {
  cv::Mat steps(1, 256, CV_8U);
  for (int i = 0; i < 256; ++i) steps.at<unsigned char>(0, i) = static_cast<unsigned char>(i);
  cv::Mat colors;
  cv::applyColorMap(steps, colors, cv::COLORMAP_TURBO);
  for (int i = 0; i < 256; ++i) {
    const Color ours = rainbow(i / 255.0);
    const int shade = i < 4 ? 33 : 22;
    const cv::Vec3b theirs = colors.at<cv::Vec3b>(0, i);
    EXPECT_NEAR(ours.red, theirs[2], shade) << i;
    EXPECT_NEAR(ours.green, theirs[1], shade) << i;
    EXPECT_NEAR(ours.blue, theirs[0], shade) << i;
  }
}

}  // namespace
}  // namespace cliquevo::tools
