// SPDX-License-Identifier: BSD-3-Clause
// Images of more than 8 bits, mosaics and JPEGs with flaws: treated alike all along, and said once.
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "drivers/describe.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<FrameSource> open(const std::string& path, Bayer bayer = Bayer::automatic) {
  RecordingOptions options;
  options.path = path;
  options.bayer = bayer;
  options.rate_hz = 10.0;
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  return source.ok() ? std::move(*source) : nullptr;
}

// A recording whose pixels are value(pixel of the ordinary one, image number).
template <typename T>
std::string made(const std::string& ending, int count, const std::function<T(int value, int image)>& value) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), count);
  for (int i = 0; i < 2 * count; ++i) {
    const std::string file = fmt::format("{}/image_{}/{:06}", dir, i % 2, i / 2);
    fs::remove(file + ".png");
    cv::Mat image(48, 64, cv::DataType<T>::type);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) image.at<T>(y, x) = value(test::pixel_of(x, y, i), i);
    }
    EXPECT_TRUE(cv::imwrite(file + ending, image));
  }
  return dir;
}

std::string deep(const std::string& ending, int count, const std::function<int(int, int)>& value) {
  return made<std::uint16_t>(ending, count, [&](int v, int i) { return static_cast<std::uint16_t>(value(v, i)); });
}

void expect_pixels(FrameSource& source, const std::function<int(int, int)>& value) {
  StereoPair pair;
  int image = 0;
  for (auto more = source.next(pair); more.ok() && *more; more = source.next(pair)) {
    for (const Image<std::uint8_t>* side : {&pair.left, &pair.right}) {
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
          ASSERT_EQ(side->cview()(x, y), value(test::pixel_of(x, y, image), image)) << image << " " << x << " " << y;
        }
      }
      ++image;
    }
  }
  EXPECT_EQ(image, 2 * static_cast<int>(source.info().frame_count));
}

bool says(const FrameSource& source, const std::string& text) {
  return describe_source(source.info()).find(text) != std::string::npos;
}

TEST(image_treatment, twelve_bits_in_sixteen_are_scaled_and_said) {
  for (const char* ending : {".png", ".tiff", ".pgm"}) {
    const auto source = open(deep(ending, 3, [](int v, int) { return v * 16 + 7; }));
    ASSERT_NE(source, nullptr);
    EXPECT_TRUE(says(*source, "samples of 12 bits, scaled by 1/16")) << source->info().description;
    expect_pixels(*source, [](int v, int) { return v; });
  }
}

TEST(image_treatment, all_images_and_both_cameras_are_scaled_alike) {
  // The first pairs are dark: what comes later decides.
  const auto source = open(deep(".png", 6, [](int v, int i) { return i < 4 ? v / 16 : v * 4 + 1; }));
  ASSERT_NE(source, nullptr);
  EXPECT_TRUE(says(*source, "samples of 10 bits, scaled by 1/4")) << source->info().description;
  expect_pixels(*source, [](int v, int i) { return i < 4 ? v / 16 / 4 : v; });
}

TEST(image_treatment, samples_at_the_top_of_the_word_and_full_ones_lose_their_low_byte) {
  for (const bool full : {false, true}) {
    const auto source = open(deep(".png", 2, [&](int v, int) { return v * 256 + (full ? v : v / 16 * 16); }));
    ASSERT_NE(source, nullptr);
    EXPECT_TRUE(says(*source, "scaled by 1/256")) << source->info().description;
    expect_pixels(*source, [](int v, int) { return v; });
  }
}

TEST(image_treatment, ordinary_images_are_not_spoken_of) {
  const auto source = open(test::write_kitti_odometry(test::scratch_dir(), 2));
  ASSERT_NE(source, nullptr);
  EXPECT_FALSE(says(*source, "bits"));
  EXPECT_FALSE(says(*source, "Bayer"));
  EXPECT_EQ(source->status(), "");
}

TEST(image_treatment, field_twelve_bits_in_png_and_pgm) {
  CLIQUEVO_NEEDS_FIELD("04-12bit-in-16");
  Image<std::uint8_t> first;
  for (const char* kind : {"png", "pgm"}) {
    const auto source = open(test::field_dir() + "/04-12bit-in-16/" + kind);
    ASSERT_NE(source, nullptr);
    EXPECT_TRUE(says(*source, "samples of 12 bits, scaled by 1/16")) << source->info().description;
    StereoPair pair;
    ASSERT_TRUE(*source->next(pair));
    if (first.empty()) {
      first.copy_from(pair.left.cview());
      const cv::Mat words = cv::imread(test::field_dir() + "/04-12bit-in-16/png/left/000000.png", cv::IMREAD_UNCHANGED);
      ASSERT_EQ(words.type(), CV_16UC1);
      for (int y = 0; y < words.rows; ++y) {
        for (int x = 0; x < words.cols; ++x) ASSERT_EQ(first.cview()(x, y), words.at<std::uint16_t>(y, x) / 16);
      }
    }
    for (int y = 0; y < first.height(); ++y) {
      ASSERT_TRUE(std::equal(first.cview().row(y), first.cview().row(y) + first.width(), pair.left.cview().row(y)));
    }
  }
}

// With times that fit its five pairs.
std::string bayer_recording() {
  const std::string dir = test::scratch_dir();
  for (const char* side : {"left", "right"}) {
    for (int i = 0; i < 5; ++i) {
      const std::string file = fmt::format("/{}/{:06}.png", side, i);
      test::write_file(dir + file, test::read_file(test::field_dir() + "/19-bayer" + file));
    }
  }
  test::write_file(dir + "/calib.txt", test::read_file(test::field_dir() + "/19-bayer/calib.txt"));
  test::write_file(dir + "/times.txt", "0\n0.1\n0.2\n0.3\n0.4\n");
  return dir;
}

TEST(image_treatment, field_mosaics_become_grey_and_are_told) {
  CLIQUEVO_NEEDS_FIELD("19-bayer");
  const std::string dir = bayer_recording();
  const auto source = open(dir);
  ASSERT_NE(source, nullptr);
  EXPECT_TRUE(says(*source, "Bayer mosaic")) << source->info().description;
  const auto raw = open(dir, Bayer::none);
  const auto named = open(dir, Bayer::rggb);
  ASSERT_TRUE(raw != nullptr && named != nullptr);
  EXPECT_FALSE(says(*raw, "Bayer"));
  EXPECT_TRUE(says(*named, "Bayer mosaic (RGGB)"));
  StereoPair a;
  StereoPair b;
  StereoPair c;
  ASSERT_TRUE(*source->next(a) && *raw->next(b) && *named->next(c));
  // Neighbours differ by colour in the one, hardly in the other.
  const auto roughness = [](const Image<std::uint8_t>& image) {
    std::int64_t sum = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 1; x < image.width(); ++x) sum += std::abs(image.cview()(x, y) - image.cview()(x - 1, y));
    }
    return static_cast<double>(sum) / (image.width() * image.height());
  };
  EXPECT_LT(4 * roughness(a.left), roughness(b.left));
  EXPECT_EQ(roughness(a.right), roughness(c.right));
}

TEST(image_treatment, no_recording_is_taken_for_a_mosaic) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  int opened = 0;
  for (const auto& entry : fs::directory_iterator(test::data_dir())) {
    RecordingOptions options;
    options.path = entry.path().string();
    options.rate_hz = 10.0;
    auto source = open_recording(options);
    if (!source.ok()) continue;
    EXPECT_FALSE(says(**source, "Bayer")) << entry.path();
    EXPECT_FALSE(says(**source, "bits")) << entry.path();
    ++opened;
  }
  EXPECT_GE(opened, 5);
}

TEST(image_treatment, jpegs_that_cost_no_pixel_are_taken_and_counted) {
  CLIQUEVO_NEEDS_FIELD("02-mjpeg-that-warns");
  const std::string dir = test::scratch_dir();
  const std::string from = test::field_dir() + "/02-mjpeg-that-warns/";
  const std::vector<std::string> names{"9_rst_plain.jpg", "A_rst_extraneous.jpg", "5_noEOI.jpg", "6_garbage_after.jpg"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (const char* side : {"left", "right"}) {
      fs::create_directories(fs::path(dir) / side);
      fs::copy(from + names[i], fmt::format("{}/{}/{:06}.jpg", dir, side, i));
    }
  }
  test::write_file(dir + "/times.txt", "0\n0.1\n0.2\n0.3\n");
  test::write_file(dir + "/calib.txt",
                   "P0: 400 0 319.5 0 0 400 199.5 0 0 0 1 0\nP1: 400 0 319.5 -48 0 400 199.5 0 0 0 1 0\n");
  const auto source = open(dir);
  ASSERT_NE(source, nullptr);
  StereoPair pair;
  for (int i = 0; i < 4; ++i) {
    const auto more = source->next(pair);
    ASSERT_TRUE(more.ok()) << more.error().line();
    ASSERT_TRUE(*more);
  }
  EXPECT_EQ(source->status(), "4 images with flaws that cost no pixel");
}

TEST(image_treatment, a_mask_of_absurd_size_is_one_line) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 2);
  test::write_file(dir + "/mask_left.png", "P5 30000 30000 255\nxxxx");  // by its content, whatever its name
  test::expect_open_error(dir, {"cannot read mask", "mask_left.png", "30000x30000"});
  test::write_file(dir + "/mask_left.png", std::string("P5 2147483647 1 255\nxxxx"));
  test::expect_open_error(dir, {"cannot read mask", "mask_left.png"});
}

}  // namespace
}  // namespace cliquevo::drivers
