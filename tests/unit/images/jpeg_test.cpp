// SPDX-License-Identifier: BSD-3-Clause
// JPEGs are taken when every pixel is there, whatever else is wrong with them; and only then.
#include "drivers/images/jpeg.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "drivers/images/decode_image.h"
#include "tests/support/test_data.h"
#include "tests/unit/images/made_images.h"

namespace cliquevo::drivers {
namespace {

test::File make_jpeg(const std::vector<int>& parameters) {
  cv::Mat image(96, 128, CV_8UC3);
  cv::RNG random(7);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  std::vector<std::uint8_t> file;
  cv::imencode(".jpg", image, file, parameters);
  return file;
}

bool same(const GreyPicture& a, const GreyPicture& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  for (int y = 0; y < a.height(); ++y) {
    if (!std::equal(a.bytes.cview().row(y), a.bytes.cview().row(y) + a.width(), b.bytes.cview().row(y))) return false;
  }
  return true;
}

TEST(Jpeg, FramesOfWhichLibjpegOnlyWarnsAreTheCleanOnesPixelForPixel) {
  CLIQUEVO_NEEDS_FIELD("02-mjpeg-that-warns");
  const std::string folder = test::field_dir() + "/02-mjpeg-that-warns/";
  GreyPicture clean;
  ASSERT_EQ(decode_image(test::read_bytes(folder + "9_rst_plain.jpg"), clean), "");
  EXPECT_EQ(clean.warnings, 0);
  for (const char* name : {"A_rst_extraneous.jpg", "5_noEOI.jpg", "6_garbage_after.jpg"}) {
    GreyPicture flawed;
    ASSERT_EQ(decode_image(test::read_bytes(folder + name), flawed), "") << name;
    EXPECT_TRUE(same(clean, flawed)) << name;
    EXPECT_EQ(flawed.warnings > 0, std::string(name) != "6_garbage_after.jpg") << name;
  }
}

TEST(Jpeg, RecordingsAreToTheByteWhatOpenCVMakesOfThem) {
  CLIQUEVO_NEEDS_DATA("walk_backyard");
  int seen = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test::data_dir())) {
    if (entry.path().extension() != ".jpg" || seen++ % 20 != 0) continue;
    GreyPicture ours;
    ASSERT_EQ(decode_image(test::read_bytes(entry.path().string()), ours), "") << entry.path();
    const cv::Mat theirs = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    ASSERT_EQ(ours.width(), theirs.cols);
    for (int y = 0; y < theirs.rows; ++y) {
      ASSERT_TRUE(
          std::equal(theirs.ptr<std::uint8_t>(y), theirs.ptr<std::uint8_t>(y) + theirs.cols, ours.bytes.cview().row(y)))
          << entry.path();
    }
  }
  EXPECT_GT(seen, 100);
}

TEST(Jpeg, ACutFileIsTakenOnlyIfNothingButItsEndIsMissing) {
  for (const auto& parameters : {std::vector<int>{}, std::vector<int>{cv::IMWRITE_JPEG_PROGRESSIVE, 1},
                                 std::vector<int>{cv::IMWRITE_JPEG_RST_INTERVAL, 4}}) {
    const test::File file = make_jpeg(parameters);
    GreyPicture whole;
    ASSERT_EQ(decode_image(file, whole), "");
    for (std::size_t size = 0; size < file.size(); size += size < file.size() - 40 ? 61 : 1) {
      GreyPicture cut;
      const bool taken = decode_image(Bytes(file.data(), size), cut).empty();
      EXPECT_TRUE(!taken || same(whole, cut)) << size << " of " << file.size();
      EXPECT_FALSE(taken && size + 40 < file.size()) << size << " of " << file.size();
      EXPECT_TRUE(taken || size + 2 != file.size());
    }
  }
}

TEST(Jpeg, DamagedDataIsRefused) {
  const test::File file = make_jpeg({cv::IMWRITE_JPEG_RST_INTERVAL, 4});
  // A stretch between two restart markers is taken out.
  std::vector<std::size_t> markers;
  for (std::size_t i = 0; i + 1 < file.size(); ++i) {
    if (file[i] == 0xFF && file[i + 1] >= 0xD0 && file[i + 1] <= 0xD7) markers.push_back(i);
  }
  ASSERT_GT(markers.size(), 4U);
  test::File without = file;
  without.erase(without.begin() + static_cast<std::ptrdiff_t>(markers[1]),
                without.begin() + static_cast<std::ptrdiff_t>(markers[2]));
  test::File shortened = file;
  shortened.erase(shortened.begin() + static_cast<std::ptrdiff_t>(markers[2] - 30),
                  shortened.begin() + static_cast<std::ptrdiff_t>(markers[2]));
  for (const test::File& bad : {without, shortened}) {
    GreyPicture picture;
    EXPECT_NE(decode_image(bad, picture), "");
  }
}

TEST(Jpeg, AnImageOfAnotherSizeIsNotWritten) {
  const test::File file = make_jpeg({});
  Image<std::uint8_t> small(64, 48);
  EXPECT_FALSE(decode_jpeg(file.data(), file.size(), small.view()).whole);
}

}  // namespace
}  // namespace cliquevo::drivers
