// SPDX-License-Identifier: BSD-3-Clause
// PGM, PPM, BMP and TIFF in the kinds that users' cameras and programs write.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <tiffio.h>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/test_data.h"
#include "tests/unit/images/made_images.h"

namespace cliquevo::drivers {
namespace {

GreyPicture decoded(Bytes file) {
  GreyPicture picture;
  EXPECT_EQ(decode_image(file, picture), "");
  return picture;
}

TEST(DecodeImage, EachFormatIsRecognisedByItselfAlone) {
  const std::string begins[] = {"\x89PNG\r\n\x1a\n", "\xFF\xD8\xFF\xE0", "P5\n", std::string("II*\0", 4), "BM"};
  ASSERT_EQ(image_formats().size(), std::size(begins));
  for (std::size_t i = 0; i < std::size(begins); ++i) {
    const std::string file = begins[i] + std::string(100, '\0');
    for (std::size_t k = 0; k < image_formats().size(); ++k) {
      EXPECT_EQ(image_formats()[k].recognises(test::bytes_of(file)), i == k) << image_formats()[k].name << ' ' << i;
    }
    for (const ImageFormat& format : image_formats()) EXPECT_FALSE(format.recognises({})) << format.name;
  }
}

TEST(DecodeNetpbm, BinaryAndTextWithComments) {
  const GreyPicture binary =
      decoded(test::bytes_of(std::string("P5 # a comment\n3 # another\n2\n255\n\x01\x02\x03\x04\x05\xff")));
  ASSERT_EQ(binary.width(), 3);
  ASSERT_EQ(binary.height(), 2);
  EXPECT_EQ(binary.bytes.cview()(2, 0), 3);
  EXPECT_EQ(binary.bytes.cview()(2, 1), 255);
  const GreyPicture text = decoded(test::bytes_of("P2\n# made by hand\n2 2\n255\n0 17\n 34 255"));
  EXPECT_EQ(text.bytes.cview()(1, 0), 17);
  EXPECT_EQ(text.bytes.cview()(1, 1), 255);
  const GreyPicture colour = decoded(test::bytes_of("P6 1 1 255\n\x10\x20\x30"));
  EXPECT_EQ(colour.bytes.cview()(0, 0), grey_of_rgb(0x10, 0x20, 0x30));
  const GreyPicture text_colour = decoded(test::bytes_of("P3 1 1 255 16 32 48\n"));
  EXPECT_EQ(text_colour.bytes.cview()(0, 0), grey_of_rgb(16, 32, 48));
}

TEST(DecodeNetpbm, TheBrightestValueTellsTheScale) {
  const GreyPicture twelve = decoded(test::bytes_of(std::string("P5 2 1 4095\n\x0f\xff\x01\x02", 16)));
  ASSERT_TRUE(twelve.deep);
  EXPECT_EQ(twelve.bits_in_use, 12);
  EXPECT_EQ(twelve.words.cview()(0, 0), 4095);
  EXPECT_EQ(twelve.words.cview()(1, 0), 0x0102);  // big-endian
  const GreyPicture full = decoded(test::bytes_of(std::string("P5 1 1 65535\n\x0f\xff", 15)));
  EXPECT_EQ(full.bits_in_use, 0);  // what every writer puts: the data has to show
  const GreyPicture odd = decoded(test::bytes_of(std::string("P5 2 1 1000\n\x03\xe8\x01\xf4", 16)));
  EXPECT_EQ(odd.bits_in_use, 16);
  EXPECT_EQ(odd.words.cview()(0, 0), 65535);
  EXPECT_NEAR(odd.words.cview()(1, 0), 32768, 1);
  const GreyPicture few = decoded(test::bytes_of(std::string("P5 3 1 15\n\x0f\x05\x7f", 13)));
  EXPECT_EQ(few.bytes.cview()(0, 0), 255);
  EXPECT_EQ(few.bytes.cview()(1, 0), 85);
  EXPECT_EQ(few.bytes.cview()(2, 0), 255);  // more than there should be: as bright as can be
}

struct BmpKind {
  int width;
  int height;  // below zero: from top to bottom
  unsigned bits;
  bool masks = false;
};

test::File make_bmp(const BmpKind& kind, const std::function<std::uint32_t(int x, int y)>& pixel) {
  const int height = std::abs(kind.height);
  const std::uint32_t palette = kind.bits <= 8 ? 1U << kind.bits : 0U;
  const std::size_t stride = (static_cast<std::size_t>(kind.width) * kind.bits + 31) / 32 * 4;
  const std::uint32_t at = 54 + 4 * palette + (kind.masks ? 12U : 0U);
  test::File file{'B', 'M'};
  test::put32(file, static_cast<std::uint32_t>(at + stride * static_cast<std::size_t>(height)));
  test::put32(file, 0);
  test::put32(file, at);
  test::put32(file, 40);
  test::put32(file, static_cast<std::uint32_t>(kind.width));
  test::put32(file, static_cast<std::uint32_t>(kind.height));
  test::put16(file, 1);
  test::put16(file, kind.bits);
  test::put32(file, kind.masks ? 3 : 0);
  for (int i = 0; i < 5; ++i) test::put32(file, 0);
  if (kind.masks) {
    for (const std::uint32_t mask : {0xFF000000U, 0x00FF0000U, 0x0000FF00U}) test::put32(file, mask);
  }
  for (std::uint32_t i = 0; i < palette; ++i) test::put32(file, i * 0x010101U * (255U / (palette - 1)));
  for (int row = 0; row < height; ++row) {
    const int y = kind.height < 0 ? row : height - 1 - row;
    test::File line;
    unsigned held = 0;
    for (int x = 0; x < kind.width; ++x) {
      if (kind.bits < 8) {
        held = held << kind.bits | pixel(x, y);
        if ((static_cast<unsigned>(x) + 1) * kind.bits % 8 == 0) line.push_back(static_cast<std::uint8_t>(held));
        if (x == kind.width - 1 && (static_cast<unsigned>(x) + 1) * kind.bits % 8 != 0) {
          line.push_back(static_cast<std::uint8_t>(held << (8 - (static_cast<unsigned>(x) + 1) * kind.bits % 8)));
        }
      } else {
        for (unsigned b = 0; b < kind.bits; b += 8) line.push_back(static_cast<std::uint8_t>(pixel(x, y) >> b));
      }
    }
    line.resize(stride);
    file.insert(file.end(), line.begin(), line.end());
  }
  return file;
}

TEST(DecodeBmp, GreyAndColourFromBottomAndFromTop) {
  const auto grey_at = [](int x, int y) { return static_cast<std::uint32_t>(x * 31 + y * 7) & 255U; };
  const auto color_at = [](int x, int y) {
    return static_cast<std::uint32_t>(x * 31 + y * 7) * 0x00010307U & 0x00FFFFFFU;
  };
  for (const int height : {5, -5}) {
    const GreyPicture grey = decoded(make_bmp({7, height, 8}, grey_at));
    const GreyPicture four = decoded(make_bmp({7, height, 4}, [&](int x, int y) { return grey_at(x, y) & 15U; }));
    const GreyPicture one = decoded(make_bmp({11, height, 1}, [&](int x, int y) { return grey_at(x, y) & 1U; }));
    const GreyPicture rgb = decoded(make_bmp({7, height, 24}, color_at));
    const GreyPicture rgbx = decoded(make_bmp({7, height, 32}, color_at));
    const GreyPicture masked =
        decoded(make_bmp({7, height, 32, true}, [&](int x, int y) { return color_at(x, y) << 8U; }));
    for (int y = 0; y < 5; ++y) {
      for (int x = 0; x < 7; ++x) {
        const std::uint32_t c = color_at(x, y);
        const unsigned color = grey_of_rgb(c >> 16U & 255U, c >> 8U & 255U, c & 255U);
        ASSERT_EQ(grey.bytes.cview()(x, y), grey_at(x, y)) << height;
        ASSERT_EQ(four.bytes.cview()(x, y), (grey_at(x, y) & 15U) * 17U) << height;
        ASSERT_EQ(one.bytes.cview()(x, y), (grey_at(x, y) & 1U) * 255U) << height;
        ASSERT_EQ(rgb.bytes.cview()(x, y), color) << height;
        ASSERT_EQ(rgbx.bytes.cview()(x, y), color) << height;
        ASSERT_EQ(masked.bytes.cview()(x, y), color) << height;
      }
    }
  }
}

struct TiffKind {
  int bits = 8;
  int samples = 1;
  int compression = COMPRESSION_NONE;
  bool tiled = false;
  bool planes = false;
  bool inverted = false;
  const char* mode = "w";  // "wb": big-endian
};

constexpr int kTiffWidth = 37;
constexpr int kTiffHeight = 50;

unsigned tiff_sample(int x, int y, int c, int bits) {
  return static_cast<unsigned>(x * 1571 + y * 977 + c * 4001) & (bits == 16 ? 0xFFFFU : 0xFFU);
}

test::File make_tiff(const TiffKind& kind) {
  const std::string path = test::scratch_dir() + "/image.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), kind.mode);
  const auto set = [tiff](std::uint32_t tag, int value) { TIFFSetField(tiff, tag, value); };
  set(TIFFTAG_IMAGEWIDTH, kTiffWidth);
  set(TIFFTAG_IMAGELENGTH, kTiffHeight);
  set(TIFFTAG_BITSPERSAMPLE, kind.bits);
  set(TIFFTAG_SAMPLESPERPIXEL, kind.samples);
  set(TIFFTAG_COMPRESSION, kind.compression);
  set(TIFFTAG_PLANARCONFIG, kind.planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  set(TIFFTAG_PHOTOMETRIC, kind.samples >= 3 ? PHOTOMETRIC_RGB
                           : kind.inverted   ? PHOTOMETRIC_MINISWHITE
                                             : PHOTOMETRIC_MINISBLACK);
  const int across = kind.tiled ? 32 : kTiffWidth;
  const int down = kind.tiled ? 16 : 8;
  if (kind.tiled) {
    set(TIFFTAG_TILEWIDTH, across);
    set(TIFFTAG_TILELENGTH, down);
  } else {
    set(TIFFTAG_ROWSPERSTRIP, down);
  }
  const int stored = kind.planes ? 1 : kind.samples;
  for (int plane = 0; plane < (kind.planes ? kind.samples : 1); ++plane) {
    for (int y0 = 0; y0 < kTiffHeight; y0 += down) {
      for (int x0 = 0; x0 < kTiffWidth; x0 += across) {
        test::File data;
        for (int y = y0; y < y0 + down && (kind.tiled || y < kTiffHeight); ++y) {
          for (int x = x0; x < x0 + across; ++x) {
            for (int c = 0; c < stored; ++c) {
              const unsigned value = tiff_sample(x, y, kind.planes ? plane : c, kind.bits);
              data.push_back(static_cast<std::uint8_t>(value));
              if (kind.bits == 16) data.push_back(static_cast<std::uint8_t>(value >> 8U));
            }
          }
        }
        const auto size = static_cast<tmsize_t>(data.size());
        const auto p = static_cast<std::uint16_t>(plane);
        const auto ux = static_cast<std::uint32_t>(x0);
        const auto uy = static_cast<std::uint32_t>(y0);
        if (kind.tiled) {
          TIFFWriteEncodedTile(tiff, TIFFComputeTile(tiff, ux, uy, 0, p), data.data(), size);
        } else {
          TIFFWriteEncodedStrip(tiff, TIFFComputeStrip(tiff, uy, p), data.data(), size);
        }
      }
    }
  }
  TIFFClose(tiff);
  return test::read_bytes(path);
}

void expect_tiff(const TiffKind& kind) {
  const std::string name = std::to_string(kind.bits) + " bits, " + std::to_string(kind.samples) + " samples, packing " +
                           std::to_string(kind.compression) + (kind.tiled ? ", tiles" : "") +
                           (kind.planes ? ", planes" : "");
  GreyPicture picture;
  ASSERT_EQ(decode_image(make_tiff(kind), picture), "") << name;
  ASSERT_EQ(picture.width(), kTiffWidth) << name;
  ASSERT_EQ(picture.height(), kTiffHeight) << name;
  for (int y = 0; y < kTiffHeight; ++y) {
    for (int x = 0; x < kTiffWidth; ++x) {
      const auto at = [&](int c) { return tiff_sample(x, y, c, kind.bits); };
      unsigned grey = kind.samples >= 3 ? grey_of_rgb(at(0), at(1), at(2)) : at(0);
      if (kind.inverted) grey = (kind.bits == 16 ? 65535U : 255U) - grey;
      const unsigned got = picture.deep ? picture.words.cview()(x, y) : picture.bytes.cview()(x, y);
      ASSERT_EQ(got, grey) << name << " at " << x << " " << y;
    }
  }
}

TEST(DecodeTiff, StripsTilesPlanesAndEveryPackingOfCameras) {
  for (const int packing : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    for (const int bits : {8, 16}) {
      for (const int samples : {1, 2, 3, 4}) {
        for (const bool tiled : {false, true}) expect_tiff({bits, samples, packing, tiled, false, false});
      }
      expect_tiff({bits, 3, packing, false, true, false});
      expect_tiff({bits, 3, packing, true, true, false});
    }
  }
  expect_tiff({8, 1, COMPRESSION_NONE, false, false, true});
  expect_tiff({16, 1, COMPRESSION_LZW, false, false, false, "wb"});
}

TEST(DecodeTiff, OtherKindsAreToldAndNotGuessed) {
  GreyPicture picture;
  const std::string said = decode_image(make_tiff({8, 3, COMPRESSION_JPEG}), picture);
  EXPECT_NE(said.find("convert it to PNG"), std::string::npos) << said;
}

TEST(DecodeImage, OpenCVsFilesOfEveryFormat) {
  cv::Mat grey(40, 56, CV_8UC1);
  cv::Mat color(40, 56, CV_8UC3);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(x * 4 + y);
      color.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(x * 4), static_cast<std::uint8_t>(y * 6),
                                   static_cast<std::uint8_t>(x + y)};
    }
  }
  for (const char* ending : {".png", ".bmp", ".tiff", ".pgm", ".ppm", ".jpg"}) {
    for (const cv::Mat* image : {&grey, &color}) {
      if (std::string(ending) == (image == &grey ? ".ppm" : ".pgm")) continue;
      std::vector<std::uint8_t> file;
      ASSERT_TRUE(cv::imencode(ending, *image, file));
      const cv::Mat theirs = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
      const GreyPicture ours = decoded(file);
      ASSERT_EQ(ours.width(), theirs.cols) << ending;
      for (int y = 0; y < theirs.rows; ++y) {
        for (int x = 0; x < theirs.cols; ++x) {
          // Where OpenCV rounds to grey, we cut, as it does for PNG.
          ASSERT_NEAR(ours.bytes.cview()(x, y), theirs.at<std::uint8_t>(y, x), image == &grey ? 0 : 1) << ending;
        }
      }
    }
  }
}

}  // namespace
}  // namespace cliquevo::drivers
