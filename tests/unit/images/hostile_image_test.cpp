// SPDX-License-Identifier: BSD-3-Clause
// Absurd sizes, torn and forged files: one clear sentence, at once, and no memory for what is not there.
#include <chrono>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/unit/images/made_images.h"

namespace cliquevo::drivers {
namespace {

test::File text(const std::string& s) { return {s.begin(), s.end()}; }

// A minimal file of each format that claims this size; there are next to no pixels behind it.
std::vector<test::File> claims(std::uint32_t width, std::uint32_t height) {
  test::PngKind kind;
  kind.claimed_width = width, kind.claimed_height = height;
  const test::File png = test::make_png(kind, [](int, int, int) { return 0U; });
  std::vector<test::File> out{png};
  test::File bmp{'B', 'M'};
  for (const std::uint32_t value : {200U, 0U, 54U, 40U, width, height}) test::put32(bmp, value);
  test::put16(bmp, 1);
  test::put16(bmp, 24);
  for (int i = 0; i < 30; ++i) test::put32(bmp, 0);
  out.push_back(bmp);
  const std::string size = std::to_string(width) + " " + std::to_string(height);
  out.push_back(text("P5 " + size + " 255\nxxxx"));
  out.push_back(text("P2 " + size + " 255\n1 2 3"));
  out.push_back(text("P6 " + size + " 65535\nxxxx"));
  test::File tiff{'I', 'I', 42, 0, 8, 0, 0, 0};
  const std::uint32_t tags[][3] = {{256, 4, width}, {257, 4, height}, {258, 3, 8},      {259, 3, 1},  {262, 3, 1},
                                   {273, 4, 8},     {277, 3, 1},      {278, 4, height}, {279, 4, 100}};
  test::put16(tiff, 9);
  for (const auto& tag : tags) {
    test::put16(tiff, tag[0]);
    test::put16(tiff, tag[1]);
    test::put32(tiff, 1);
    test::put32(tiff, tag[2]);
  }
  test::put32(tiff, 0);
  out.push_back(tiff);
  if (width < 65536 && height < 65536) {
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", cv::Mat(16, 16, CV_8UC1, cv::Scalar(100)), jpeg);
    for (std::size_t i = 0; i + 8 < jpeg.size(); ++i) {
      if (jpeg[i] != 0xFF || jpeg[i + 1] != 0xC0) continue;
      jpeg[i + 5] = static_cast<std::uint8_t>(height >> 8U), jpeg[i + 6] = static_cast<std::uint8_t>(height);
      jpeg[i + 7] = static_cast<std::uint8_t>(width >> 8U), jpeg[i + 8] = static_cast<std::uint8_t>(width);
      break;
    }
    out.push_back(jpeg);
  }
  return out;
}

bool is_a_sentence(const std::string& s) {
  return s.size() > 10 && s.find_first_of("\n\r\x1b") == std::string::npos && s.find('\0') == std::string::npos;
}

TEST(HostileImage, AbsurdSizesAreRefusedFromTheHeader) {
  const auto begin = std::chrono::steady_clock::now();
  for (const auto& [width, height] : {std::pair{30000U, 30000U}, std::pair{16000U, 16000U}, std::pair{65535U, 1000U},
                                      std::pair{0x7FFFFFFFU, 0x7FFFFFFFU}, std::pair{0xFFFFFFFFU, 1U}}) {
    for (const test::File& file : claims(width, height)) {
      GreyPicture picture;
      const std::string said = decode_image(file, picture);
      EXPECT_TRUE(is_a_sentence(said)) << said;
      if (width == 30000U) {
        EXPECT_NE(said.find("30000x30000"), std::string::npos) << said << " " << int{file[0]};
      }
      EXPECT_EQ(picture.width(), 0) << "memory was taken for " << width << "x" << height;
    }
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
}

TEST(HostileImage, SizesWithoutTheirDataAreTorn) {
  for (const test::File& file : claims(8000, 8000)) {
    GreyPicture picture;
    EXPECT_TRUE(is_a_sentence(decode_image(file, picture)));
    EXPECT_EQ(picture.width(), 0) << "memory was taken for pixels that cannot be there: " << int{file[0]};
  }
}

std::vector<test::File> whole_files() {
  cv::Mat image(24, 32, CV_8UC3);
  cv::RNG random(11);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  std::vector<test::File> out;
  for (const char* ending : {".png", ".bmp", ".tiff", ".ppm", ".jpg"}) {
    out.emplace_back();
    cv::imencode(ending, image, out.back());
  }
  out.push_back(test::make_png({23, 19, 4, 3, true, test::File(48, 9), 0, 0}, [](int x, int, int) { return x & 15U; }));
  return out;
}

TEST(HostileImage, TornFilesAreNeverTaken) {
  for (const test::File& file : whole_files()) {
    GreyPicture picture;
    ASSERT_EQ(decode_image(file, picture), "");
    const bool jpeg = file[0] == 0xFF;
    const bool tiff = file[0] == 'I';  // its directory may stand behind the pixels, with words that are not needed
    for (std::size_t size = 0; size + (jpeg ? 8 : tiff ? 64 : 1) < file.size(); size += 7) {
      const std::string said = decode_image(Bytes(file.data(), size), picture);
      EXPECT_TRUE(is_a_sentence(said)) << size << " of " << file.size() << " bytes: " << int{file[0]};
    }
  }
}

TEST(HostileImage, ForgedBytesNeverCrash) {
  std::mt19937 random(17);
  for (const test::File& file : whole_files()) {
    for (int round = 0; round < 300; ++round) {
      test::File forged = file;
      for (int i = 0; i < 1 + round % 5; ++i) {
        const std::size_t at = random() % (round % 2 == 0 ? forged.size() : std::min<std::size_t>(forged.size(), 200));
        forged[at] = static_cast<std::uint8_t>(random());
      }
      GreyPicture picture;
      const std::string said = decode_image(forged, picture);
      EXPECT_TRUE(said.empty() || is_a_sentence(said)) << said;
    }
  }
}

TEST(HostileImage, OtherFilesAreToldWhatIsRead) {
  GreyPicture picture;
  for (const std::string& bytes : {std::string(), std::string("hello"), std::string(1000, '\0'),
                                   std::string("RIFF\x10\0\0\0WEBPVP8 ", 16), std::string("P5"), std::string("BM")}) {
    const std::string said = decode_image(test::bytes_of(bytes), picture);
    EXPECT_TRUE(is_a_sentence(said)) << said;
  }
  EXPECT_NE(decode_image(test::bytes_of("GIF89a"), picture).find("convert it to PNG"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::drivers
