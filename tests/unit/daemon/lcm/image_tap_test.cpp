// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/image_tap.h"

#include <algorithm>
#include <zlib.h>

#include <gtest/gtest.h>

#include "daemon/lcm/messages.h"

namespace cliquevo::daemon {
namespace {

constexpr std::int64_t kFrameNs = 33'333'333;

struct Frame {
  Image<std::uint8_t> left{7, 5};
  Image<std::uint8_t> right{7, 5};
  Image<std::int16_t> disparity{7, 5};
  explicit Frame(std::uint8_t grey, std::int16_t value) {
    left.fill(grey);
    right.fill(static_cast<std::uint8_t>(grey + 100));
    disparity.fill(value);
  }
};

TEST(ImageTap, GivesWhatItWasOfferedWithUnknownAndNegativeDisparityAsZero) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 10.0});
  EXPECT_EQ(tap.take(), nullptr);
  Frame frame(9, 160);
  frame.disparity.view()(3, 2) = kUnknownDisparity;
  frame.disparity.view()(4, 2) = -5;
  tap.offer(1000, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  const TappedImages* seen = tap.take();
  ASSERT_NE(seen, nullptr);
  EXPECT_EQ(seen->stamp_ns, 1000);
  EXPECT_EQ(seen->left.cview()(6, 4), 9);
  EXPECT_EQ(seen->disparity.cview()(6, 4), 160);
  EXPECT_EQ(seen->disparity.cview()(3, 2), 0);
  EXPECT_EQ(seen->disparity.cview()(4, 2), 0);
}

TEST(ImageTap, KeepsToItsRateInTheFramesOwnTime) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 5.0});
  const Frame frame(1, 16);
  int taken = 0;
  for (int i = 0; i < 90; ++i) {
    tap.offer(i * kFrameNs, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
    if (tap.take() == nullptr) continue;
    ++taken;
    tap.give_back();
  }
  EXPECT_GE(taken, 12);
  EXPECT_LE(taken, 16);
}

TEST(ImageTap, WhatNobodyHasTakenIsNotOverwritten) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 100.0});
  const Frame first(1, 16);
  tap.offer(0, first.left.cview(), first.right.cview(), first.disparity.cview());
  const Frame later(2, 32);
  tap.offer(1'000'000'000, later.left.cview(), later.right.cview(), later.disparity.cview());
  ASSERT_NE(tap.take(), nullptr);
  EXPECT_EQ(tap.take()->left.cview()(0, 0), 1);
  tap.give_back();
  tap.offer(2'000'000'000, later.left.cview(), later.right.cview(), later.disparity.cview());
  ASSERT_NE(tap.take(), nullptr);
  EXPECT_EQ(tap.take()->left.cview()(0, 0), 2);
}

TEST(ImageTap, SwitchedOffItGivesNothing) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 0.0});
  const Frame frame(1, 16);
  tap.offer(0, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  EXPECT_EQ(tap.take(), nullptr);
}

TEST(ImageTap, ASourceThatBeginsAnewIsSeenAgain) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 1.0});
  const Frame frame(1, 16);
  tap.offer(5'000'000'000, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  tap.give_back();
  tap.offer(0, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  EXPECT_NE(tap.take(), nullptr);
}

TEST(ImageTap, WithoutBeingAskedForThereIsNoRightImageAndNoMask) {
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 10.0});
  const Frame frame(1, 16);
  tap.offer(0, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  images_t sent;
  build_images(*tap.take(), StereoModel{.width = 7, .height = 5}, sent);
  EXPECT_EQ(sent.n_images, 2);
  EXPECT_EQ(sent.image_types, (std::vector<std::int16_t>{images_t::LEFT, images_t::DISPARITY}));
  EXPECT_EQ(sent.images.size(), 2U);
}

TEST(ImageTap, RightImageAndMaskStandBehindWhatWasSentBefore) {
  Image<std::uint8_t> mask(7, 5);
  mask.fill(255);
  mask.view()(2, 1) = 0;
  ImageTap tap({.width = 7, .height = 5, .rate_hz = 10.0, .right = true, .mask = mask.cview()});
  const Frame frame(1, 16);
  tap.offer(0, frame.left.cview(), frame.right.cview(), frame.disparity.cview());
  images_t sent;
  build_images(*tap.take(), StereoModel{.width = 7, .height = 5, .baseline_m = 0.25}, sent);
  ASSERT_EQ(sent.image_types,
            (std::vector<std::int16_t>{images_t::LEFT, images_t::DISPARITY, images_t::RIGHT, images_t::MASK_ZIPPED}));
  ASSERT_EQ(sent.images.size(), 4U);
  const image_t& right = sent.images[2];
  EXPECT_EQ(right.pixelformat, image_t::PIXEL_FORMAT_GRAY);
  EXPECT_EQ(right.size, 35);
  EXPECT_EQ(std::count(right.data.begin(), right.data.end(), 101), 35);
  const image_t& zipped = sent.images[3];
  EXPECT_EQ(zipped.size, static_cast<std::int32_t>(zipped.data.size()));
  std::vector<std::uint8_t> plain(35);
  uLongf size = plain.size();
  ASSERT_EQ(uncompress(plain.data(), &size, zipped.data.data(), zipped.data.size()), Z_OK);
  ASSERT_EQ(size, 35U);
  EXPECT_EQ(plain[9], 0);
  EXPECT_EQ(std::count(plain.begin(), plain.end(), 255), 34);
  for (const image_t& image : sent.images) {
    EXPECT_EQ(image.width, 7);
    EXPECT_EQ(image.height, 5);
    EXPECT_EQ(image.nmetadata, static_cast<std::int32_t>(image.metadata.size()));
    EXPECT_EQ(image.metadata.size(), 6U);
  }
}

}  // namespace
}  // namespace cliquevo::daemon
