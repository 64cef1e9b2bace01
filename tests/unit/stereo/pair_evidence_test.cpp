// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/pair_evidence.h"

#include <cmath>

#include <gtest/gtest.h>

namespace cliquevo::stereo {
namespace {

// A wall of smooth random spots at disparity `shift`, the right image `down` rows lower.
Image<std::uint8_t> picture(int width, int height, double shift, double down) {
  Image<std::uint8_t> out(width, height);
  const auto noise = [](int x, int y) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B9U + static_cast<std::uint32_t>(y) * 0x85EBCA6BU;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    return static_cast<double>((h ^ (h >> 13U)) & 255U);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + shift) / 6.0 + 100.0;
      const double v = (y - down) / 6.0 + 100.0;
      const int i = static_cast<int>(std::floor(u));
      const int j = static_cast<int>(std::floor(v));
      const double a = u - i;
      const double b = v - j;
      out.view()(x, y) = static_cast<std::uint8_t>((1 - b) * ((1 - a) * noise(i, j) + a * noise(i + 1, j)) +
                                                   b * ((1 - a) * noise(i, j + 1) + a * noise(i + 1, j + 1)));
    }
  }
  return out;
}

TEST(pair_evidence, rows_and_disparities_are_measured) {
  const auto left = picture(640, 480, 0.0, 0.0);
  for (const auto& [shift, down] : {std::pair{20.0, 0.0}, {33.5, 4.0}, {8.0, -6.5}}) {
    const auto right = picture(640, 480, shift, down);
    const RowEvidence seen = measure_rows(left.cview(), right.cview());
    ASSERT_GT(seen.corners, 60);
    EXPECT_GT(seen.found(), seen.corners / 2);
    EXPECT_NEAR(seen.median_off_px(), std::abs(down), 0.3);
    EXPECT_NEAR(seen.disparity_px(0.5), shift, 0.5);
    EXPECT_EQ(seen.share_within(1.0) > 0.5, std::abs(down) < 1.0);
  }
}

TEST(pair_evidence, other_pictures_give_none) {
  const auto left = picture(640, 480, 0.0, 0.0);
  const auto other = picture(640, 480, 5000.0, 3000.0);
  const RowEvidence seen = measure_rows(left.cview(), other.cview());
  EXPECT_LT(seen.found(), seen.corners / 10);
  Image<std::uint8_t> bare(640, 480);
  bare.fill(90);
  EXPECT_EQ(measure_rows(bare.cview(), bare.cview()).found(), 0);
  EXPECT_EQ(measure_rows(left.cview(), bare.cview()).found(), 0);
  EXPECT_EQ(measure_rows(left.cview(), picture(320, 240, 0, 0).cview()).corners, 0);
}

}  // namespace
}  // namespace cliquevo::stereo
