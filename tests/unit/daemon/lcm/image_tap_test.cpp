// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/image_tap.h"

#include <gtest/gtest.h>

namespace cliquevo::daemon {
namespace {

constexpr std::int64_t kFrameNs = 33'333'333;

struct Frame {
  Image<std::uint8_t> left{7, 5};
  Image<std::int16_t> disparity{7, 5};
  explicit Frame(std::uint8_t grey, std::int16_t value) {
    left.fill(grey);
    disparity.fill(value);
  }
};

TEST(ImageTap, GivesWhatItWasOfferedWithUnknownAndNegativeDisparityAsZero) {
  ImageTap tap(7, 5, 10.0);
  EXPECT_EQ(tap.take(), nullptr);
  Frame frame(9, 160);
  frame.disparity.view()(3, 2) = kUnknownDisparity;
  frame.disparity.view()(4, 2) = -5;
  tap.offer(1000, frame.left.cview(), frame.disparity.cview());
  const TappedImages* seen = tap.take();
  ASSERT_NE(seen, nullptr);
  EXPECT_EQ(seen->stamp_ns, 1000);
  EXPECT_EQ(seen->left.cview()(6, 4), 9);
  EXPECT_EQ(seen->disparity.cview()(6, 4), 160);
  EXPECT_EQ(seen->disparity.cview()(3, 2), 0);
  EXPECT_EQ(seen->disparity.cview()(4, 2), 0);
}

TEST(ImageTap, KeepsToItsRateInTheFramesOwnTime) {
  ImageTap tap(7, 5, 5.0);
  const Frame frame(1, 16);
  int taken = 0;
  for (int i = 0; i < 90; ++i) {
    tap.offer(i * kFrameNs, frame.left.cview(), frame.disparity.cview());
    if (tap.take() == nullptr) continue;
    ++taken;
    tap.give_back();
  }
  EXPECT_GE(taken, 12);
  EXPECT_LE(taken, 16);
}

TEST(ImageTap, WhatNobodyHasTakenIsNotOverwritten) {
  ImageTap tap(7, 5, 100.0);
  tap.offer(0, Frame(1, 16).left.cview(), Frame(1, 16).disparity.cview());
  const Frame later(2, 32);
  tap.offer(1'000'000'000, later.left.cview(), later.disparity.cview());
  ASSERT_NE(tap.take(), nullptr);
  EXPECT_EQ(tap.take()->left.cview()(0, 0), 1);
  tap.give_back();
  tap.offer(2'000'000'000, later.left.cview(), later.disparity.cview());
  ASSERT_NE(tap.take(), nullptr);
  EXPECT_EQ(tap.take()->left.cview()(0, 0), 2);
}

TEST(ImageTap, SwitchedOffItGivesNothing) {
  ImageTap tap(7, 5, 0.0);
  const Frame frame(1, 16);
  tap.offer(0, frame.left.cview(), frame.disparity.cview());
  EXPECT_EQ(tap.take(), nullptr);
}

TEST(ImageTap, ASourceThatBeginsAnewIsSeenAgain) {
  ImageTap tap(7, 5, 1.0);
  const Frame frame(1, 16);
  tap.offer(5'000'000'000, frame.left.cview(), frame.disparity.cview());
  tap.give_back();
  tap.offer(0, frame.left.cview(), frame.disparity.cview());
  EXPECT_NE(tap.take(), nullptr);
}

}  // namespace
}  // namespace cliquevo::daemon
