// SPDX-License-Identifier: BSD-3-Clause
// Every format that cameras deliver becomes the same grey image; both images of one frame come apart.
#include "drivers/pixels/pixels.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <jpeglib.h>
#include <linux/videodev2.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

constexpr int kWidth = 16;
constexpr int kHeight = 4;

std::uint8_t grey(int x, int y) { return static_cast<std::uint8_t>(10 * x + 3 * y); }

// A frame whose pixels have `bytes` each, of which `fill` sets those that matter.
template <typename Fill>
std::vector<std::uint8_t> frame_of(std::size_t bytes, std::size_t gap, const Fill& fill) {
  std::vector<std::uint8_t> out((bytes * kWidth + gap) * kHeight, 77);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      fill(&out[static_cast<std::size_t>(y) * (bytes * kWidth + gap) + bytes * static_cast<std::size_t>(x)], x, y);
    }
  }
  return out;
}

void expect_grey(const RawFrame& frame, int tolerance = 0) {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  ASSERT_TRUE(to_grey(frame, CameraLayout::two_cameras, left, right)) << fourcc_name(frame.fourcc);
  ASSERT_TRUE(left.cview().same_size(kWidth, kHeight));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_NEAR(left.cview()(x, y), grey(x, y), tolerance) << fourcc_name(frame.fourcc) << " " << x << " " << y;
    }
  }
}

void set16(std::uint8_t* to, unsigned value) {
  to[0] = static_cast<std::uint8_t>(value & 255U);
  to[1] = static_cast<std::uint8_t>(value >> 8U);
}

TEST(Pixels, PackedFormatsBecomeGreyAlsoWithGapsBetweenRows) {
  for (const std::size_t gap : {std::size_t{0}, std::size_t{6}}) {
    const auto check = [gap](std::uint32_t fourcc, std::size_t bytes, const auto& fill) {
      const auto data = frame_of(bytes, gap, fill);
      expect_grey({data.data(), data.size(), fourcc, kWidth, kHeight, gap == 0 ? 0 : bytes * kWidth + gap});
    };
    check(V4L2_PIX_FMT_GREY, 1, [](std::uint8_t* to, int x, int y) { *to = grey(x, y); });
    check(V4L2_PIX_FMT_YUYV, 2, [](std::uint8_t* to, int x, int y) { to[0] = grey(x, y); });
    check(V4L2_PIX_FMT_UYVY, 2, [](std::uint8_t* to, int x, int y) { to[1] = grey(x, y); });
    check(V4L2_PIX_FMT_Y10, 2, [](std::uint8_t* to, int x, int y) { set16(to, grey(x, y) * 4U + 3U); });
    check(V4L2_PIX_FMT_Y12, 2, [](std::uint8_t* to, int x, int y) { set16(to, grey(x, y) * 16U + 9U); });
    check(V4L2_PIX_FMT_Y16, 2, [](std::uint8_t* to, int x, int y) { set16(to, grey(x, y) * 256U + 200U); });
  }
}

TEST(Pixels, BothImagesOfOneFrameComeApart) {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  const auto side = frame_of(1, 0, [](std::uint8_t* to, int x, int y) { *to = grey(x, y); });
  ASSERT_TRUE(to_grey({side.data(), side.size(), V4L2_PIX_FMT_GREY, kWidth, kHeight, 0}, CameraLayout::side_by_side,
                      left, right));
  EXPECT_EQ(image_width(CameraLayout::side_by_side, V4L2_PIX_FMT_GREY, kWidth), 8);
  EXPECT_EQ(left.cview()(7, 2), grey(7, 2));
  EXPECT_EQ(right.cview()(0, 2), grey(8, 2));
  ASSERT_TRUE(to_grey({side.data(), side.size(), V4L2_PIX_FMT_GREY, kWidth, kHeight, 0}, CameraLayout::interleaved,
                      left, right));
  EXPECT_EQ(left.cview()(3, 1), grey(6, 1));
  EXPECT_EQ(right.cview()(3, 1), grey(7, 1));
  const auto pairs = frame_of(2, 0, [](std::uint8_t* to, int x, int y) {
    to[0] = grey(x, y);
    to[1] = static_cast<std::uint8_t>(200 - x);
  });
  ASSERT_TRUE(to_grey({pairs.data(), pairs.size(), V4L2_PIX_FMT_YUYV, kWidth, kHeight, 0}, CameraLayout::interleaved,
                      left, right));
  ASSERT_TRUE(left.cview().same_size(kWidth, kHeight) && right.cview().same_size(kWidth, kHeight));
  EXPECT_EQ(left.cview()(5, 3), grey(5, 3));
  EXPECT_EQ(right.cview()(5, 3), 195);
}

TEST(Pixels, SamplesThatShareBytesBecomeGrey) {
  // Four samples in five bytes, two in three: upper bits first. Rows may have gaps.
  for (const std::size_t gap : {std::size_t{0}, std::size_t{4}}) {
    std::vector<std::uint8_t> ten((kWidth / 4 * 5 + gap) * kHeight, 99);
    std::vector<std::uint8_t> twelve((kWidth / 2 * 3 + gap) * kHeight, 99);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ten[static_cast<std::size_t>(y) * (kWidth / 4 * 5 + gap) + static_cast<std::size_t>(x / 4 * 5 + x % 4)] =
            grey(x, y);
        twelve[static_cast<std::size_t>(y) * (kWidth / 2 * 3 + gap) + static_cast<std::size_t>(x / 2 * 3 + x % 2)] =
            grey(x, y);
      }
    }
    expect_grey({ten.data(), ten.size(), V4L2_PIX_FMT_Y10P, kWidth, kHeight, kWidth / 4 * 5 + gap});
    expect_grey({twelve.data(), twelve.size(), v4l2_fourcc('Y', '1', '2', 'P'), kWidth, kHeight, kWidth / 2 * 3 + gap});
    Image<std::uint8_t> left;
    Image<std::uint8_t> right;
    EXPECT_FALSE(to_grey({ten.data(), ten.size() - gap - 1, V4L2_PIX_FMT_Y10P, kWidth, kHeight, kWidth / 4 * 5 + gap},
                         CameraLayout::two_cameras, left, right));
    ASSERT_TRUE(to_grey({ten.data(), ten.size(), V4L2_PIX_FMT_Y10P, kWidth, kHeight, kWidth / 4 * 5 + gap},
                        CameraLayout::side_by_side, left, right));
    EXPECT_EQ(right.cview()(3, 2), grey(kWidth / 2 + 3, 2));
  }
  std::vector<std::uint8_t> bits(kWidth * 10 / 8 * kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const unsigned value = grey(i % kWidth, i / kWidth) * 4U + 3U;
    for (int b = 0; b < 10; ++b) {
      const int at = 10 * i + b;
      if ((value >> (9 - b) & 1U) != 0)
        bits[static_cast<std::size_t>(at / 8)] |= static_cast<std::uint8_t>(0x80U >> (at % 8));
    }
  }
  expect_grey({bits.data(), bits.size(), V4L2_PIX_FMT_Y10BPACK, kWidth, kHeight, 0});
}

TEST(Pixels, MosaicsBecomeGreyInEveryPatternAndDepth) {
  struct Case {
    std::uint32_t fourcc;
    int bits;
    int green;  // parity of x + y of the green pixels
  };
  for (const Case& c :
       {Case{V4L2_PIX_FMT_SRGGB8, 8, 1}, Case{V4L2_PIX_FMT_SGRBG8, 8, 0}, Case{V4L2_PIX_FMT_SBGGR10, 10, 1},
        Case{V4L2_PIX_FMT_SGBRG12, 12, 0}, Case{V4L2_PIX_FMT_SBGGR16, 16, 1}}) {
    const std::size_t bytes = c.bits > 8 ? 2 : 1;
    const auto data = frame_of(bytes, 0, [&](std::uint8_t* to, int x, int y) {
      const unsigned value = (x + y) % 2 == c.green ? 200U : y % 2 == 0 ? 40U : 80U;
      if (c.bits == 8) {
        *to = static_cast<std::uint8_t>(value);
      } else {
        set16(to, value << (c.bits - 8));
      }
    });
    Image<std::uint8_t> left;
    Image<std::uint8_t> right;
    EXPECT_TRUE(is_known_format(c.fourcc) && is_mosaic_format(c.fourcc));
    ASSERT_TRUE(
        to_grey({data.data(), data.size(), c.fourcc, kWidth, kHeight, 0}, CameraLayout::two_cameras, left, right));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) EXPECT_EQ(left.cview()(x, y), (40 + 2 * 200 + 80) / 4) << fourcc_name(c.fourcc);
    }
  }
  EXPECT_FALSE(is_mosaic_format(V4L2_PIX_FMT_GREY));
}

TEST(Pixels, JpegFramesThatOnlyMakeTheDecoderWarnAreTakenAndMarked) {
  CLIQUEVO_NEEDS_FIELD("02-mjpeg-that-warns");
  Image<std::uint8_t> clean;
  Image<std::uint8_t> none;
  for (const char* name : {"9_rst_plain.jpg", "A_rst_extraneous.jpg", "5_noEOI.jpg", "6_garbage_after.jpg"}) {
    std::ifstream in(test::field_dir() + "/02-mjpeg-that-warns/" + name, std::ios::binary);
    const std::vector<char> bytes(std::istreambuf_iterator<char>(in), {});
    Image<std::uint8_t> image;
    const RawFrame frame{
        reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), V4L2_PIX_FMT_MJPEG, 640, 400, 0};
    const Conversion got = to_grey(frame, CameraLayout::two_cameras, image, none);
    ASSERT_TRUE(got.whole) << name;
    EXPECT_EQ(got.flawed, name[0] == 'A' || name[0] == '5') << name;
    if (clean.empty()) clean.copy_from(image.cview());
    for (int y = 0; y < 400; ++y) {
      ASSERT_TRUE(std::equal(clean.cview().row(y), clean.cview().row(y) + 640, image.cview().row(y))) << name;
    }
  }
}

TEST(Pixels, FramesThatAreNotWholeAreRefused) {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  const auto data = frame_of(2, 0, [](std::uint8_t* to, int x, int y) { to[0] = grey(x, y); });
  EXPECT_FALSE(to_grey({data.data(), data.size() - 1, V4L2_PIX_FMT_YUYV, kWidth, kHeight, 0}, CameraLayout::two_cameras,
                       left, right));
  EXPECT_FALSE(to_grey({data.data(), data.size(), V4L2_PIX_FMT_RGB24, kWidth, kHeight, 0}, CameraLayout::two_cameras,
                       left, right));
  EXPECT_FALSE(to_grey({data.data(), data.size(), V4L2_PIX_FMT_MJPEG, kWidth, kHeight, 0}, CameraLayout::two_cameras,
                       left, right));
}

TEST(Pixels, JpegIsDecodedWholeOrNotAtAll) {
  const auto pixels = frame_of(1, 0, [](std::uint8_t* to, int x, int y) { *to = grey(x, y); });
  jpeg_compress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < kHeight; ++y) {
    auto* row = const_cast<std::uint8_t*>(&pixels[static_cast<std::size_t>(y * kWidth)]);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  expect_grey({bytes, size, V4L2_PIX_FMT_MJPEG, kWidth, kHeight, 0}, 3);
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  for (unsigned long cut = 0; cut + 2 < size; cut += 7) {
    EXPECT_FALSE(to_grey({bytes, cut, V4L2_PIX_FMT_MJPEG, kWidth, kHeight, 0}, CameraLayout::two_cameras, left, right))
        << cut << " of " << size << " bytes";
  }
  std::free(bytes);
}

}  // namespace
}  // namespace cliquevo::drivers
