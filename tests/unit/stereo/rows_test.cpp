// SPDX-License-Identifier: BSD-3-Clause
// The steps before and after matching, on rows whose right answer is known: pre-filter, smoothing, usable area.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "stereo/block_matcher.h"
#include "stereo/kernels/kernels.h"
#include "stereo/prefilter.h"
#include "stereo/smoothing.h"
#include "stereo/usable_area.h"

namespace cliquevo::stereo {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 12;

template <typename F>
Image<std::uint8_t> drawn(F&& f) {
  Image<std::uint8_t> image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) image.view()(x, y) = static_cast<std::uint8_t>(f(x, y));
  }
  return image;
}

struct Prefiltered {
  Image<std::uint8_t> filtered{kWidth, kHeight};
  MatchingPair matching;
};

void prefilter(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right, const StereoParams& params,
               Prefiltered& out) {
  out.matching.prepare(kWidth, kHeight);
  prefilter_rows(kernels::tables().reference(), params, left.cview(), right.cview(), 0, kHeight, out.filtered.view(),
                 out.matching);
}

TEST(Prefilter, OfAFlatPictureIsTheMiddleOfItsRange) {
  const StereoParams params;
  const auto flat = drawn([](int, int) { return 77; });
  Prefiltered out;
  prefilter(flat, flat, params, out);
  const int range = matching_curve(params).range;
  for (int x = 2; x < kWidth - 2; ++x) {
    EXPECT_EQ(out.filtered.view()(x, 5), params.prefilter_cap);
    EXPECT_EQ(out.matching.left.row(5)[x], range);
    EXPECT_EQ(out.matching.right[0].row(5)[x], range);
    EXPECT_EQ(out.matching.right[1].row(5)[x], range);
  }
}

TEST(Prefilter, TakesBrightnessAwayAndKeepsTheSignOfSlopes) {
  for (const Prefilter kind : {Prefilter::xsobel, Prefilter::gradients}) {
    StereoParams params;
    params.prefilter = kind;
    const auto slope = drawn([](int x, int) { return 20 + x; });
    const auto brighter = drawn([](int x, int) { return 60 + x; });
    const auto falling = drawn([](int x, int) { return 120 - x; });
    Prefiltered a, b, c;
    prefilter(slope, slope, params, a);
    prefilter(brighter, brighter, params, b);
    prefilter(falling, falling, params, c);
    for (int x = 2; x < kWidth - 2; ++x) {
      const int up = a.filtered.view()(x, 5) - params.prefilter_cap;
      EXPECT_GT(up, 0);
      EXPECT_EQ(b.filtered.view()(x, 5) - params.prefilter_cap, up);
      EXPECT_EQ(c.filtered.view()(x, 5) - params.prefilter_cap, -up);
      EXPECT_EQ(a.matching.right[0].row(5)[x], b.matching.right[0].row(5)[x]);
    }
  }
}

TEST(Prefilter, AnEdgeEndsAtTheCap) {
  const StereoParams params;
  const auto edge = drawn([](int x, int) { return x < 32 ? 10 : 240; });
  Prefiltered out;
  prefilter(edge, edge, params, out);
  EXPECT_EQ(out.filtered.view()(31, 5), 2 * params.prefilter_cap);
  EXPECT_EQ(out.filtered.view()(32, 5), 2 * params.prefilter_cap);
  EXPECT_EQ(out.matching.right[0].row(5)[32], 2 * matching_curve(params).range);
}

TEST(Prefilter, GradientsAlternateAsTheSquaresOfAChessboard) {
  StereoParams params;
  const auto vertical = drawn([](int, int y) { return 20 + 8 * y; });
  Prefiltered out;
  prefilter(vertical, vertical, params, out);
  const int range = matching_curve(params).range;
  for (int y = 3; y < 6; ++y) {
    for (int x = 10; x < 20; ++x) {
      const bool rises = out.matching.left.row(y)[x] > range;
      EXPECT_EQ(rises, kernels::channel(matching_channels(params), x, y) == 1) << x << ' ' << y;
    }
  }
  params.prefilter = Prefilter::xsobel;
  EXPECT_EQ(matching_channels(params), kernels::Channels::horizontal);
}

TEST(MatchingImage, HasMarginsOfNothing) {
  MatchingImage image;
  image.prepare(kWidth, kHeight);
  EXPECT_GE(image.stride(), kWidth + 2 * kernels::kMargin);
  for (int k = 1; k <= kernels::kMargin; ++k) {
    ASSERT_EQ(image.row(3)[-k], 0);
    ASSERT_EQ(image.row(3)[kWidth - 1 + k], 0);
  }
}

TEST(StripMatcher, FindsByHowMuchTheRightPictureIsShifted) {
  constexpr int kShift = 7;
  const auto texture = [](int x, int y) {
    return 120 + std::lround(50 * std::sin(0.9 * x + 0.7 * y) + 45 * std::sin(0.37 * x - 1.1 * y + x * x * 0.01));
  };
  StereoParams params;
  params.num_disparities = 16;
  const auto left = drawn(texture);
  const auto right = drawn([&](int x, int y) { return texture(x + kShift, y); });
  Prefiltered rows;
  prefilter(left, right, params, rows);
  StripMatcher matcher;
  matcher.prepare(params, kWidth);
  Image<std::int16_t> disparity(kWidth, kHeight);
  disparity.fill(kUnknownDisparity);
  for (int y = 0; y < kHeight; ++y) {
    matcher.match(kernels::tables().reference(), params, rows.matching, rows.filtered.cview(), y, 1, y == 0,
                  disparity.view());
  }
  int known = 0;
  for (int x = 26; x < 50; ++x) {
    const int d = disparity.view()(x, 6);
    if (d == kUnknownDisparity) continue;
    ++known;
    EXPECT_NEAR(d / double{kDisparityScale}, kShift, 0.3) << x;
  }
  EXPECT_GE(known, 20);
}

// Disparities of one row, of which every row of the picture is a copy, after smoothing.
std::vector<std::int16_t> smoothed(const std::vector<std::int16_t>& row, int radius) {
  const int width = static_cast<int>(row.size());
  Image<std::int16_t> in(width, kHeight), out(width, kHeight);
  for (int y = 0; y < kHeight; ++y) std::copy(row.begin(), row.end(), in.view().row(y));
  Smoother smoother;
  smoother.prepare(width, radius);
  smoother.smooth(
      kernels::tables().reference(), in.cview(), 0, kHeight, [](int, std::int16_t*) {}, out.view());
  return {out.view().row(6), out.view().row(6) + width};
}

TEST(Smoother, TakesNoiseAwayAndLeavesASlope) {
  std::vector<std::int16_t> noisy(40), slope(40);
  for (std::size_t x = 0; x < noisy.size(); ++x) {
    noisy[x] = static_cast<std::int16_t>(160 + (x % 2 == 0 ? 5 : -5));
    slope[x] = static_cast<std::int16_t>(160 + x);
  }
  const auto calm = smoothed(noisy, 2);
  const auto straight = smoothed(slope, 2);
  for (std::size_t x = 4; x < 36; ++x) {
    EXPECT_NEAR(calm[x], 160, 2);
    EXPECT_NEAR(straight[x], slope[x], 1);
  }
  EXPECT_EQ(smoothed(noisy, 0), noisy);
}

TEST(Smoother, DoesNotMixSurfacesAndLeavesTheUnknownUnknown) {
  std::vector<std::int16_t> step(40, 160);
  for (std::size_t x = 20; x < 40; ++x) step[x] = 160 + 2 * kDisparityScale;
  step[10] = kUnknownDisparity;
  EXPECT_EQ(smoothed(step, 3), step);
}

TEST(UsableArea, DropsDisparitiesWhoseRightPixelMustNotBeUsed) {
  Image<std::uint8_t> area(kWidth, kHeight);
  area.fill(255);
  for (int y = 0; y < kHeight; ++y) area.view()(30, y) = 0;
  Image<std::int16_t> disparity(kWidth, kHeight);
  disparity.fill(static_cast<std::int16_t>(4.4 * kDisparityScale));
  disparity.view()(35, 2) = static_cast<std::int16_t>(4.6 * kDisparityScale);   // rounded to 5
  disparity.view()(28, 3) = static_cast<std::int16_t>(-2.0 * kDisparityScale);  // to the right
  disparity.view()(33, 4) = kUnknownDisparity;
  drop_unusable(area.cview(), disparity.view());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool dropped = x == 34 || (x == 35 && y == 2) || (x == 28 && y == 3) || (x == 33 && y == 4);
      ASSERT_EQ(disparity.view()(x, y) == kUnknownDisparity, dropped) << x << ' ' << y;
    }
  }
}

TEST(UsableArea, IsEmptyWhereAllMayBeUsedElseTheMaskAsRectified) {
  StereoCalibration c;
  c.rectified = true;
  c.prescribed = PrescribedRectification{};
  c.prescribed->model = {kWidth, 16, 50, 50, 32, 8, 0.1, 0.0};
  c.left.width = c.right.width = kWidth;
  c.left.height = c.right.height = 16;
  const auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
  const auto all = usable_area(*rectifier, CameraSide::left, {}, c.left);
  ASSERT_TRUE(all.ok()) << all.error().line();
  EXPECT_TRUE(all->empty());
  Image<std::uint8_t> mask(kWidth, 16);
  mask.fill(255);
  for (int y = 7; y < 16; ++y) std::fill(mask.view().row(y), mask.view().row(y) + 10, std::uint8_t{0});
  const auto part = usable_area(*rectifier, CameraSide::right, mask.cview(), c.right);
  ASSERT_TRUE(part.ok()) << part.error().line();
  ASSERT_FALSE(part->empty());
  EXPECT_EQ(part->cview()(5, 8), 0);
  EXPECT_NE(part->cview()(30, 8), 0);
  Image<std::uint8_t> small(10, 10);
  small.fill(255);
  EXPECT_FALSE(usable_area(*rectifier, CameraSide::left, small.cview(), c.left).ok());
}

}  // namespace
}  // namespace cliquevo::stereo
