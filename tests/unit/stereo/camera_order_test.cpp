// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/camera_order.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::stereo {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 200;

// A wall with a coarse texture, `disparity` px apart in the two cameras; the right one `down` rows lower.
struct Pair {
  Image<std::uint8_t> left{kWidth, kHeight};
  Image<std::uint8_t> right{kWidth, kHeight};
};
Pair wall(int disparity, unsigned seed, int down = 0, double noise = 2.0) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> grey(0.0, noise);
  std::uniform_int_distribution<int> any(0, 255);
  constexpr int kCell = 3;
  Image<std::uint8_t> texture((kWidth + 200) / kCell, (kHeight + 40) / kCell);
  for (int y = 0; y < texture.height(); ++y) {
    for (int x = 0; x < texture.width(); ++x) texture.view()(x, y) = static_cast<std::uint8_t>(any(rng));
  }
  const auto at = [&](int x, int y) {
    return std::clamp(texture.cview()((x + 90) / kCell, (y + 10) / kCell) + grey(rng), 0.0, 255.0);
  };
  Pair out;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      out.left.view()(x, y) = static_cast<std::uint8_t>(at(x, y));
      out.right.view()(x, y) = static_cast<std::uint8_t>(at(x + disparity, y - down));
    }
  }
  return out;
}

CameraOrder order_of(int disparity, int down = 0) {
  auto check = CameraOrderCheck::make(kWidth, kHeight);
  EXPECT_TRUE(check.ok());
  for (unsigned i = 0; i < 3; ++i) {
    const Pair pair = wall(disparity, i, down);
    check->add(check->measure(pair.left.cview(), pair.right.cview()));
  }
  return check->order();
}

TEST(CameraOrder, IsToldByTheSideOnWhichMatchesLie) {
  for (const int disparity : {6, 12, 25, 40}) {
    EXPECT_EQ(order_of(disparity), CameraOrder::as_said) << disparity;
    EXPECT_EQ(order_of(-disparity), CameraOrder::exchanged) << disparity;
  }
}

TEST(CameraOrder, BearsAFewRowsOfError) {
  EXPECT_EQ(order_of(-16, 4), CameraOrder::exchanged);
  EXPECT_EQ(order_of(16, -4), CameraOrder::as_said);
}

TEST(CameraOrder, IsUnknownFarAwayWithoutContrastAndBeforeTheSecondPair) {
  EXPECT_EQ(order_of(0), CameraOrder::unknown) << "infinitely far";
  auto check = CameraOrderCheck::make(kWidth, kHeight);
  ASSERT_TRUE(check.ok());
  Image<std::uint8_t> bare(kWidth, kHeight);
  bare.fill(90);
  for (int i = 0; i < 3; ++i) check->add(check->measure(bare.cview(), bare.cview()));
  EXPECT_EQ(check->order(), CameraOrder::unknown);
  EXPECT_TRUE(describe(check->order()).empty());
  auto fresh = CameraOrderCheck::make(kWidth, kHeight);
  const Pair pair = wall(-20, 1);
  fresh->add(fresh->measure(pair.left.cview(), pair.right.cview()));
  EXPECT_EQ(fresh->order(), CameraOrder::unknown);
  EXPECT_EQ(fresh->measure(bare.cview(), Image<std::uint8_t>(8, 8).cview()).forward, 0.0) << "of another size";
}

TEST(CameraOrder, UnrelatedPicturesTellNothing) {
  auto check = CameraOrderCheck::make(kWidth, kHeight);
  ASSERT_TRUE(check.ok());
  for (unsigned i = 0; i < 4; ++i) {
    const Pair a = wall(10, i);
    const Pair b = wall(10, i + 100);
    check->add(check->measure(a.left.cview(), b.left.cview()));
  }
  EXPECT_EQ(check->order(), CameraOrder::unknown);
}

TEST(CameraOrder, TheSamePictureTwiceIsToldFromAFarScene) {
  auto check = CameraOrderCheck::make(kWidth, kHeight);
  ASSERT_TRUE(check.ok());
  for (unsigned i = 0; i < 3; ++i) {
    const Pair pair = wall(0, i);
    check->add(check->measure(pair.left.cview(), pair.left.cview()));
    EXPECT_FALSE(are_identical(pair.left.cview(), pair.right.cview())) << "each camera has its own noise";
  }
  EXPECT_EQ(check->order(), CameraOrder::same);
  EXPECT_NE(describe(check->order()).find("same picture"), std::string::npos);
  EXPECT_NE(describe(CameraOrder::exchanged).find("--swap-eyes"), std::string::npos);
}

TEST(CameraOrder, SmallImagesAreRefusedOrBorne) {
  EXPECT_FALSE(CameraOrderCheck::make(0, 0).ok());
  EXPECT_FALSE(CameraOrderCheck::make(12, 12).ok());
  EXPECT_TRUE(CameraOrderCheck::make(64, 48).ok());
}

}  // namespace
}  // namespace cliquevo::stereo
