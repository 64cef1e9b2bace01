// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/pair_evidence.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/noise_picture.h"

namespace cliquevo::stereo {
namespace {

using test::noise_picture;

TEST(pair_evidence, rows_and_disparities_are_measured) {
  const auto left = noise_picture(640, 480, 0.0, 0.0);
  for (const auto& [shift, down] : {std::pair{20.0, 0.0}, {33.5, 4.0}, {8.0, -6.5}}) {
    const auto right = noise_picture(640, 480, shift, down);
    const RowEvidence seen = measure_rows(left.cview(), right.cview());
    ASSERT_GT(seen.corners, 60);
    EXPECT_GT(seen.found(), seen.corners / 2);
    EXPECT_NEAR(seen.median_off_px(), std::abs(down), 0.3);
    EXPECT_NEAR(seen.disparity_px(0.5), shift, 0.5);
    EXPECT_EQ(seen.share_within(1.0) > 0.5, std::abs(down) < 1.0);
  }
}

TEST(pair_evidence, other_pictures_give_none) {
  const auto left = noise_picture(640, 480, 0.0, 0.0);
  const auto other = noise_picture(640, 480, 5000.0, 3000.0);
  const RowEvidence seen = measure_rows(left.cview(), other.cview());
  EXPECT_LT(seen.found(), seen.corners / 10);
  Image<std::uint8_t> bare(640, 480);
  bare.fill(90);
  EXPECT_EQ(measure_rows(bare.cview(), bare.cview()).found(), 0);
  EXPECT_EQ(measure_rows(left.cview(), bare.cview()).found(), 0);
  EXPECT_EQ(measure_rows(left.cview(), noise_picture(320, 240, 0, 0).cview()).corners, 0);
}

}  // namespace
}  // namespace cliquevo::stereo
