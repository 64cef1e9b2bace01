// SPDX-License-Identifier: BSD-3-Clause
// Corners of made pictures: single bright pixels, of which each is one corner, and of which nothing else is.
#include "core/vo/features.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/matches.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{320, 240, 300.0, 300.0, 159.5, 119.5, 0.2, 0.0};
constexpr double kDisparity_px = 12.5;

class Dots {
 public:
  Dots() : image(kModel.width, kModel.height), disparity(kModel.width, kModel.height) {
    image.fill(100);
    disparity.fill(static_cast<std::int16_t>(kDisparity_px * kDisparityScale));
  }
  void add(int x, int y, int contrast) { image.view()(x, y) = static_cast<std::uint8_t>(100 + contrast); }
  std::vector<Feature> found_by(FeatureDetector& detector, double offset_px = 0.0) const {
    std::vector<Feature> out;
    detector.detect(image.cview(), disparity.cview(), mask.cview(), offset_px, out);
    return out;
  }

  Image<std::uint8_t> image;
  Image<std::int16_t> disparity;
  Image<std::uint8_t> mask;
};

bool has(const std::vector<Feature>& features, int x, int y) {
  return std::any_of(features.begin(), features.end(), [&](const Feature& f) { return f.x == x && f.y == y; });
}

TEST(FeatureDetector, FindsDotsWhereTheyAreWithTheirDepth) {
  FeatureDetector detector(kModel, {});
  Dots dots;
  dots.add(60, 50, 80);
  dots.add(200, 50, 120);
  dots.add(260, 190, 40);
  const std::vector<Feature> found = dots.found_by(detector);
  ASSERT_EQ(found.size(), 3U);
  for (const Feature& f : found) {
    EXPECT_EQ(f.disparity_px, kDisparity_px);
    EXPECT_NEAR(f.point.z(), 300.0 * 0.2 / kDisparity_px, 1e-9);
    EXPECT_NEAR((kModel.project(f.point) - Eigen::Vector3d(f.x, f.y, kDisparity_px)).norm(), 0.0, 1e-9);
  }
  EXPECT_TRUE(has(found, 60, 50) && has(found, 200, 50) && has(found, 260, 190));
}

TEST(FeatureDetector, TheScoreIsTheLargestThresholdAtWhichItIsACorner) {
  FeatureDetector detector(kModel, {});
  Dots dots;
  dots.add(60, 50, 80);
  const std::vector<Feature> found = dots.found_by(detector);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].score, 79) << "darker by more than so much all around";
}

TEST(FeatureDetector, LeavesOutWhatHasNoDepthIsMaskedOrTouchesTheBorder) {
  FeatureDetector detector(kModel, {});
  Dots dots;
  dots.mask.resize(kModel.width, kModel.height);
  dots.mask.fill(255);
  dots.add(60, 50, 80);
  dots.add(100, 50, 80);
  dots.disparity.view()(100, 50) = kUnknownDisparity;
  dots.add(140, 50, 80);
  dots.mask.view()(140, 50) = 0;
  dots.add(kFeatureMargin - 1, 100, 80);
  dots.add(200, kModel.height - kFeatureMargin, 80);
  dots.add(240, 100, 80);
  dots.disparity.view()(240, 100) = static_cast<std::int16_t>(0.5 * kDisparityScale);
  const std::vector<Feature> found = dots.found_by(detector, 1.0);  // disparities are a pixel too large
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(has(found, 60, 50));
}

TEST(FeatureDetector, DarkPicturesAreLookedAtWithLessContrastAndNoiseIsNot) {
  const VoParams params;
  FeatureDetector detector(kModel, params);
  Dots dots;
  dots.add(60, 50, params.min_corner_threshold + 2);
  dots.add(100, 50, params.min_corner_threshold - 1);
  const std::vector<Feature> found = dots.found_by(detector);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(has(found, 60, 50));
}

TEST(FeatureDetector, EveryCellGetsItsShareHoweverStrongAnotherOneIs) {
  VoParams params;
  params.max_features = 50;
  FeatureDetector detector(kModel, params);
  Dots dots;
  for (int y = 66; y < 94; y += 4) {
    for (int x = 66; x < 94; x += 4) dots.add(x, y, 150);  // 49 in one cell of 32 px
  }
  for (int y = 16; y < 224; y += 32) {
    for (int x = 16; x < 320; x += 32) {
      if (x / 32 != 2 || y / 32 != 2) dots.add(x, y, 40);
    }
  }
  const std::vector<Feature> found = dots.found_by(detector);
  EXPECT_EQ(found.size(), 50U);
  const auto strong = std::count_if(found.begin(), found.end(), [](const Feature& f) { return f.score > 100; });
  EXPECT_LE(strong, 2);
  EXPECT_GE(strong, 1);
}

TEST(FeatureDetector, ThePicturesBeforeChangeNothing) {
  FeatureDetector fresh(kModel, {});
  FeatureDetector used(kModel, {});
  Dots bright, dark;
  for (int i = 0; i < 30; ++i) {
    bright.add(20 + 9 * i, 30 + 6 * i, 60 + 5 * i);
    dark.add(20 + 9 * i, 200 - 6 * i, 6);
  }
  const std::vector<Feature> expected = bright.found_by(fresh);
  EXPECT_EQ(dark.found_by(used).size(), 30U);
  const std::vector<Feature> found = bright.found_by(used);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].x, expected[i].x);
    EXPECT_EQ(found[i].score, expected[i].score);
  }
}

TEST(Descriptors, CoarseOnesSeeTwiceTheSurroundings) {
  // A picture that differs at 6 px from the feature alone: beyond the usual window of 7, within 14.
  Image<std::uint8_t> plain(64, 64), marked(64, 64);
  plain.fill(50);
  marked.fill(50);
  for (int y = 28; y < 36; ++y) marked.view()(26, y) = marked.view()(27, y) = 200;
  Feature f;
  f.x = f.y = 32;
  const auto differs = [&](bool coarse) {
    Descriptors a(1), b(1);
    coarse ? a.extract_coarse(plain.cview(), {f}) : a.extract(plain.cview(), {f}, 7);
    coarse ? b.extract_coarse(marked.cview(), {f}) : b.extract(marked.cview(), {f}, 7);
    EXPECT_EQ(a.length(), b.length());
    return !std::equal(a[0], a[0] + a.length(), b[0]);
  };
  EXPECT_FALSE(differs(false));
  EXPECT_TRUE(differs(true));
}

}  // namespace
}  // namespace cliquevo::vo
