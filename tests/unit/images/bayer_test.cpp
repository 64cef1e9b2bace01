// SPDX-License-Identifier: BSD-3-Clause
// Mosaics are distinguished from grey images beyond doubt, and become grey without a trace of their cells.
#include "drivers/images/bayer.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "drivers/images/image_reader.h"
#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

using Rgb = std::array<double, 3>;

// Smooth patches of changing colour and fine texture, like a scene; `balance` is the sensor's answer to white.
Rgb scene(int x, int y, const Rgb& balance) {
  const double light = 120 + 50 * std::sin(0.11 * x + 0.07 * y) + 25 * std::sin(0.9 * x) * std::cos(0.8 * y);
  return {light * balance[0] * (1 + 0.2 * std::sin(0.02 * x)), light * balance[1],
          light * balance[2] * (1 + 0.2 * std::cos(0.03 * y))};
}

// cell: which colour the upper left, upper right, lower left and lower right pixels see.
Image<std::uint8_t> mosaic(const std::array<int, 4>& cell, const Rgb& balance) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 2.0);
  Image<std::uint8_t> image(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double value =
          scene(x, y, balance)[static_cast<std::size_t>(cell[static_cast<std::size_t>(y % 2 * 2 + x % 2)])];
      image.view()(x, y) = static_cast<std::uint8_t>(std::clamp(value + noise(random), 0.0, 255.0));
    }
  }
  return image;
}

MosaicEvidence evidence_of(ImageView<const std::uint8_t> image) {
  MosaicEvidence evidence;
  evidence.add(image);
  return evidence;
}

constexpr std::array<int, 4> kRggb{0, 1, 1, 2};
constexpr std::array<int, 4> kBggr{2, 1, 1, 0};
constexpr std::array<int, 4> kGrbg{1, 0, 2, 1};
constexpr std::array<int, 4> kGbrg{1, 2, 0, 1};

TEST(Bayer, EveryPatternIsFoundWithItsGreenPixels) {
  for (const Rgb& balance : {Rgb{0.5, 1.0, 0.6}, Rgb{0.9, 1.0, 0.6}, Rgb{1.1, 1.0, 0.8}}) {
    EXPECT_TRUE(evidence_of(mosaic(kRggb, balance).cview()).is_mosaic()) << balance[0];
    EXPECT_FALSE(evidence_of(mosaic(kRggb, balance).cview()).green_first());
    EXPECT_TRUE(evidence_of(mosaic(kBggr, balance).cview()).is_mosaic());
    EXPECT_FALSE(evidence_of(mosaic(kBggr, balance).cview()).green_first());
    EXPECT_TRUE(evidence_of(mosaic(kGrbg, balance).cview()).is_mosaic());
    EXPECT_TRUE(evidence_of(mosaic(kGrbg, balance).cview()).green_first());
    EXPECT_TRUE(evidence_of(mosaic(kGbrg, balance).cview()).is_mosaic());
    EXPECT_TRUE(evidence_of(mosaic(kGbrg, balance).cview()).green_first());
  }
}

TEST(Bayer, StripesNoiseAndUnevenRowsAreNoMosaic) {
  std::mt19937 random(5);
  const auto made = [&](const auto& value) {
    Image<std::uint8_t> image(320, 240);
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x)
        image.view()(x, y) = static_cast<std::uint8_t>(std::clamp<double>(value(x, y), 0, 255));
    }
    return evidence_of(image.cview()).is_mosaic();
  };
  std::uniform_real_distribution<double> any(0, 255);
  EXPECT_FALSE(made([&](int, int) { return any(random); }));
  EXPECT_FALSE(made([](int, int) { return 0.0; }));
  EXPECT_FALSE(made([](int, int) { return 255.0; }));
  EXPECT_FALSE(made([](int x, int y) { return x * 0.5 + y * 0.2; }));
  EXPECT_FALSE(made([](int, int y) { return y % 2 == 0 ? 120.0 : 90.0; }));              // interlaced
  EXPECT_FALSE(made([](int x, int) { return x % 2 == 0 ? 100.0 : 104.0; }));             // two converters a row
  EXPECT_FALSE(made([](int x, int y) { return 128 + 100 * std::sin(0.8 * (x + y)); }));  // fine diagonal stripes
  EXPECT_FALSE(made([](int x, int y) { return 128 + 100 * std::sin(2.0 * (x - y)); }));
  EXPECT_FALSE(evidence_of(Image<std::uint8_t>(8, 8).cview()).is_mosaic());
}

TEST(Bayer, NoRecordingOfGreyOrColourImagesIsTakenForAMosaic) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  int images = 0;
  int seen = 0;
  ImageReader reader;
  Image<std::uint8_t> image;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test::data_dir())) {
    const std::string ending = entry.path().extension().string();
    if ((ending != ".png" && ending != ".jpg") || seen++ % 25 != 0) continue;
    ASSERT_TRUE(reader.read(entry.path().string(), image).ok()) << entry.path();
    EXPECT_FALSE(evidence_of(image.cview()).is_mosaic()) << entry.path();
    ++images;
  }
  EXPECT_GT(images, 40);
}

TEST(Bayer, EveryPatternBecomesTheSameGreyWithoutCells) {
  const Rgb balance{0.5, 1.0, 0.6};
  MosaicToGrey to_grey;
  for (const auto& cell : {kRggb, kBggr, kGrbg, kGbrg}) {
    Image<std::uint8_t> image(64, 48);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        constexpr std::array<int, 3> kColor{60, 200, 100};
        image.view()(x, y) = static_cast<std::uint8_t>(
            kColor[static_cast<std::size_t>(cell[static_cast<std::size_t>(y % 2 * 2 + x % 2)])]);
      }
    }
    to_grey.convert(image.view());
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) ASSERT_EQ(image.cview()(x, y), (60 + 2 * 200 + 100) / 4) << x << " " << y;
    }
    Image<std::uint8_t> scenery = mosaic(cell, balance);
    to_grey.convert(scenery.view());
    EXPECT_FALSE(evidence_of(scenery.cview()).is_mosaic());
  }
}

TEST(Bayer, ImagesOfAPixelOrTwoAreLeftOrConverted) {
  MosaicToGrey to_grey;
  for (const auto& [w, h] : {std::pair{1, 1}, std::pair{1, 5}, std::pair{5, 1}, std::pair{2, 2}, std::pair{3, 2}}) {
    Image<std::uint8_t> image(w, h);
    image.fill(77);
    to_grey.convert(image.view());
    EXPECT_EQ(image.cview()(w - 1, h - 1), 77);
  }
}

}  // namespace
}  // namespace cliquevo::drivers
