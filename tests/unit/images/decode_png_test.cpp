// SPDX-License-Identifier: BSD-3-Clause
// Every kind of PNG that the format has becomes the grey of its samples.
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "drivers/images/png_writer.h"
#include "tests/support/test_data.h"
#include "tests/unit/images/made_images.h"

namespace cliquevo::drivers {
namespace {

unsigned pattern(int x, int y, int channel, unsigned most) {
  return static_cast<unsigned>(x * 37 + y * 91 + channel * 53 + x * y) % (most + 1);
}

struct Case {
  int depth;
  int color_type;
};

TEST(DecodePng, EveryDepthAndColourTypePlainAndInterlaced) {
  const Case cases[] = {{1, 0}, {2, 0}, {4, 0}, {8, 0}, {16, 0}, {8, 2}, {16, 2}, {8, 4}, {16, 4}, {8, 6}, {16, 6}};
  for (const Case& c : cases) {
    for (const bool interlaced : {false, true}) {
      const unsigned most = (1U << c.depth) - 1U;
      test::PngKind kind{13, 11, c.depth, c.color_type, interlaced, {}, 0, 0};
      const test::File file = test::make_png(kind, [&](int x, int y, int ch) { return pattern(x, y, ch, most); });
      GreyPicture picture;
      ASSERT_EQ(decode_image(file, picture), "") << c.depth << " bits, colour type " << c.color_type;
      ASSERT_EQ(picture.deep, c.depth == 16);
      ASSERT_EQ(picture.width(), kind.width);
      ASSERT_EQ(picture.height(), kind.height);
      for (int y = 0; y < kind.height; ++y) {
        for (int x = 0; x < kind.width; ++x) {
          const bool colour = (c.color_type & 2) != 0;
          unsigned grey = pattern(x, y, 0, most);
          if (colour) grey = grey_of_rgb(grey, pattern(x, y, 1, most), pattern(x, y, 2, most));
          if (c.depth < 8) grey = grey * 255U / most;
          const unsigned got = picture.deep ? picture.words.cview()(x, y) : picture.bytes.cview()(x, y);
          ASSERT_EQ(got, grey) << c.depth << " bits, type " << c.color_type << ", at " << x << " " << y << " "
                               << interlaced;
        }
      }
    }
  }
}

TEST(DecodePng, PalettesOfEveryDepth) {
  for (const int depth : {1, 2, 4, 8}) {
    const unsigned colors = 1U << depth;
    test::PngKind kind{17, 9, depth, 3, false, {}, 0, 0};
    for (unsigned i = 0; i < colors; ++i) {
      for (unsigned c = 0; c < 3; ++c) kind.palette.push_back(static_cast<std::uint8_t>((i * 67 + c * 101) & 255U));
    }
    const test::File file = test::make_png(kind, [&](int x, int y, int) { return pattern(x, y, 0, colors - 1); });
    GreyPicture picture;
    ASSERT_EQ(decode_image(file, picture), "") << depth;
    for (int y = 0; y < kind.height; ++y) {
      for (int x = 0; x < kind.width; ++x) {
        const std::uint8_t* entry = &kind.palette[3 * pattern(x, y, 0, colors - 1)];
        ASSERT_EQ(picture.bytes.cview()(x, y), grey_of_rgb(entry[0], entry[1], entry[2])) << depth;
      }
    }
  }
}

// What the pictures of recordings were until now.
void expect_as_opencv(const std::string& path) {
  const cv::Mat theirs = cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  GreyPicture picture;
  ASSERT_EQ(decode_image(test::read_bytes(path), picture), "") << path;
  ASSERT_FALSE(picture.deep) << path;
  ASSERT_EQ(picture.width(), theirs.cols) << path;
  ASSERT_EQ(picture.height(), theirs.rows) << path;
  int most = 0;
  for (int y = 0; y < theirs.rows; ++y) {
    for (int x = 0; x < theirs.cols; ++x) {
      most = std::max(most, std::abs(picture.bytes.cview()(x, y) - theirs.at<std::uint8_t>(y, x)));
    }
  }
  EXPECT_EQ(most, 0) << path;
}

TEST(DecodePng, RecordingsAreToTheByteWhatOpenCVMakesOfThem) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  int seen = 0;
  int checked = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test::data_dir())) {
    const std::string path = entry.path().string();
    const bool depth = path.find("disp") != std::string::npos;
    if (entry.path().extension() != ".png" || depth) continue;
    if (seen++ % 40 == 0 || path.find("rover") != std::string::npos) {
      expect_as_opencv(path);
      ++checked;
    }
  }
  EXPECT_GT(checked, 12);
}

TEST(DecodePng, WhatIsWrittenIsReadBack) {
  Image<std::uint8_t> grey(33, 7);
  Image<std::uint16_t> deep(33, 7);
  Image<std::uint8_t> rgb(3 * 33, 7);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 33; ++x) {
      grey.view()(x, y) = static_cast<std::uint8_t>(pattern(x, y, 0, 255));
      deep.view()(x, y) = static_cast<std::uint16_t>(pattern(x, y, 0, 65535) * 97);
      for (int c = 0; c < 3; ++c) rgb.view()(3 * x + c, y) = static_cast<std::uint8_t>(pattern(x, y, c, 255));
    }
  }
  const auto grey_file = encode_png(grey.cview());
  const auto deep_file = encode_png(deep.cview());
  const auto rgb_file = encode_png_rgb(rgb.cview());
  ASSERT_TRUE(grey_file.ok() && deep_file.ok() && rgb_file.ok());
  const cv::Mat a = cv::imdecode(*grey_file, cv::IMREAD_UNCHANGED);
  const cv::Mat b = cv::imdecode(*deep_file, cv::IMREAD_UNCHANGED);
  const cv::Mat c = cv::imdecode(*rgb_file, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(a.type(), CV_8UC1);
  ASSERT_EQ(b.type(), CV_16UC1);
  ASSERT_EQ(c.type(), CV_8UC3);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 33; ++x) {
      ASSERT_EQ(a.at<std::uint8_t>(y, x), grey.cview()(x, y));
      ASSERT_EQ(b.at<std::uint16_t>(y, x), deep.cview()(x, y));
      for (int i = 0; i < 3; ++i) ASSERT_EQ(c.at<cv::Vec3b>(y, x)[2 - i], rgb.cview()(3 * x + i, y));
    }
  }
}

}  // namespace
}  // namespace cliquevo::drivers
