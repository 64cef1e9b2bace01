// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/sample_depth.h"

#include <gtest/gtest.h>

namespace cliquevo::drivers {
namespace {

// Values from 0 to `most`, in steps of `step`.
GreyPicture words(unsigned most, unsigned step, int bits_in_use = 0) {
  GreyPicture picture;
  picture.deep = true;
  picture.bits_in_use = bits_in_use;
  picture.words.resize(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const unsigned value = most * static_cast<unsigned>(64 * y + x) / 4095U;
      picture.words.view()(x, y) = static_cast<std::uint16_t>(value / step * step);
    }
  }
  return picture;
}

int shift_of(const GreyPicture& picture) {
  SampleDepth depth;
  depth.add(picture);
  return depth.shift();
}

TEST(SampleDepth, TheBitsInUseTellTheSensor) {
  EXPECT_EQ(shift_of(words(255, 1)), 0);
  EXPECT_EQ(shift_of(words(1023, 1)), 2);
  EXPECT_EQ(shift_of(words(4095, 1)), 4);
  EXPECT_EQ(shift_of(words(16383, 1)), 6);
  EXPECT_EQ(shift_of(words(65535, 1)), 8);
}

TEST(SampleDepth, ADarkPictureLeavesTheTopBitEmpty) {
  EXPECT_EQ(shift_of(words(1500, 1)), 4);
  EXPECT_EQ(shift_of(words(600, 1)), 2);
  EXPECT_EQ(shift_of(words(40000, 1)), 8);
}

TEST(SampleDepth, SamplesAtTheTopOfTheirWordKeepTheirPlace) {
  EXPECT_EQ(shift_of(words(65535, 16)), 8);  // 12 bits
  EXPECT_EQ(shift_of(words(65535, 64)), 8);  // 10 bits
  EXPECT_EQ(shift_of(words(9000, 16)), 8);   // 12 bits, a dark picture
  EXPECT_EQ(shift_of(words(4095, 16)), 4);   // few values of a 12-bit sensor are none of 16 bits
}

TEST(SampleDepth, WhatTheFileTellsComesFirst) {
  EXPECT_EQ(shift_of(words(900, 1, 12)), 4);
  EXPECT_EQ(shift_of(words(900, 1, 16)), 8);
  EXPECT_EQ(shift_of(words(100, 1, 9)), 1);
}

TEST(SampleDepth, AllImagesCountTogether) {
  SampleDepth depth;
  depth.add(words(700, 1));
  depth.add(words(3000, 1));
  GreyPicture bytes;
  bytes.bytes.resize(4, 4);
  depth.add(bytes);
  EXPECT_TRUE(depth.deep());
  EXPECT_EQ(depth.shift(), 4);
  SampleDepth ordinary;
  ordinary.add(bytes);
  EXPECT_FALSE(ordinary.deep());
}

TEST(SampleDepth, BrighterThanExpectedStaysWhite) {
  const GreyPicture picture = words(8191, 1);
  Image<std::uint8_t> bytes;
  shift_to_bytes(picture.words.cview(), 4, bytes);
  EXPECT_EQ(bytes.cview()(63, 63), 255);
  EXPECT_EQ(bytes.cview()(0, 0), 0);
  EXPECT_EQ(bytes.cview()(0, 16), picture.words.cview()(0, 16) / 16);
}

}  // namespace
}  // namespace cliquevo::drivers
