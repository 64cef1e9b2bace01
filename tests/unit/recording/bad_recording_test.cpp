// SPDX-License-Identifier: BSD-3-Clause
// A recording that is broken is an error that states what, where and what to do.
#include <filesystem>

#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;
using test::expect_open_error;
using test::write_file;
using test::write_image;

std::string good(int count = 4) { return test::write_kitti_odometry(test::scratch_dir(), count); }

// Plays to the end and gives the errors on the way; every other pair must arrive.
std::vector<Error> errors_of(const std::string& path, int pairs) {
  RecordingOptions options;
  options.path = path;
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  std::vector<Error> errors;
  if (!source.ok()) return errors;
  StereoPair pair;
  int count = 0;
  for (;;) {
    const Result<bool> more = (*source)->next(pair);
    if (more.ok() && !*more) break;
    EXPECT_EQ(pair.index, count);
    EXPECT_EQ(pair.stamp_ns, count * 100'000'000LL);
    if (!more.ok()) errors.push_back(more.error());
    ++count;
  }
  EXPECT_EQ(count, pairs);
  return errors;
}

TEST(bad_recording, folder_that_is_missing_empty_or_no_folder) {
  const std::string dir = test::scratch_dir();
  expect_open_error(dir + "/none", {"no such recording", dir + "/none"});
  expect_open_error(dir, {"empty", dir});
  expect_open_error("", {"no such recording"});
  write_file(dir + "/notes.txt", "hello");
  expect_open_error(dir + "/notes.txt", {"no folder", "notes.txt"});
  expect_open_error(dir, {"no stereo recording", "image_0", "mav0", "left"});
}

TEST(bad_recording, one_camera_missing_or_without_images) {
  std::string dir = good();
  fs::remove_all(dir + "/image_1");
  expect_open_error(dir, {"right images are missing", "image_1"});
  fs::create_directory(dir + "/image_1");
  expect_open_error(dir, {"no images", "image_1"});
  dir = good();
  fs::remove_all(dir + "/image_0");
  expect_open_error(dir, {"left images are missing", "image_0"});
  dir = test::scratch_dir();
  write_image(dir + "/mav0/cam0/data/1700000000000000000.png", 64, 48, 0);
  expect_open_error(dir, {"right images are missing", "cam1"});
  dir = test::scratch_dir();
  write_image(dir + "/image_00/data/0.png", 64, 48, 0);
  expect_open_error(dir, {"right images are missing", "image_01/data"});
  dir = test::scratch_dir();
  write_image(dir + "/right/0.png", 64, 48, 0);
  expect_open_error(dir, {"left images are missing", "left"});
}

TEST(bad_recording, image_without_partner_is_named_and_the_rest_plays) {
  const std::string dir = good();
  fs::remove(dir + "/image_1/000002.png");
  const std::vector<Error> errors = errors_of(dir, 4);
  ASSERT_EQ(errors.size(), 1U);
  test::expect_clear(errors[0], {"no partner", "image_0/000002.png"});
}

TEST(bad_recording, cameras_whose_images_have_nothing_in_common) {
  const std::string dir = good();
  for (const char* name : {"0", "1", "2", "3"}) {
    fs::rename(dir + "/image_1/00000" + name + ".png", dir + "/image_1/x" + name + "y7.png");
  }
  expect_open_error(dir, {"no partner", "image_0/000000.png"});
}

TEST(bad_recording, cameras_of_unequal_size) {
  const std::string dir = good();
  for (const char* name : {"0", "1", "2", "3"}) write_image(dir + "/image_1/00000" + name + ".png", 32, 48, 0);
  expect_open_error(dir, {"unequal size", "64x48", "32x48", "image_1/000000.png"});
}

TEST(bad_recording, another_size_later_in_the_sequence) {
  const std::string dir = good();
  write_image(dir + "/image_0/000002.png", 64, 40, 0);
  const std::vector<Error> errors = errors_of(dir, 4);
  ASSERT_EQ(errors.size(), 1U);
  test::expect_clear(errors[0], {"size", "64x40", "64x48", "image_0/000002.png"});
}

TEST(bad_recording, torn_image_in_the_middle_is_named_and_the_rest_plays) {
  for (const double part : {0.0, 0.01, 0.5, 0.99}) {
    const std::string dir = good(6);
    test::truncate_file(dir + "/image_1/000003.png", part);
    const std::vector<Error> errors = errors_of(dir, 6);
    ASSERT_EQ(errors.size(), 1U) << part;
    test::expect_clear(errors[0], {"cannot read image", "image_1/000003.png"});
  }
}

TEST(bad_recording, torn_first_image_is_left_to_the_replay) {
  const std::string dir = good();
  test::truncate_file(dir + "/image_0/000000.png", 0.5);
  const std::vector<Error> errors = errors_of(dir, 4);
  ASSERT_EQ(errors.size(), 1U);
  test::expect_clear(errors[0], {"image_0/000000.png", "torn"});
}

TEST(bad_recording, image_with_a_flipped_byte_is_torn) {
  const std::string dir = good();
  std::string bytes = test::read_file(dir + "/image_0/000001.png");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x40);
  write_file(dir + "/image_0/000001.png", bytes);
  ASSERT_EQ(errors_of(dir, 4).size(), 1U);
}

TEST(bad_recording, cut_jpeg_is_torn_not_grey) {
  const std::string dir = good();
  for (const char* side : {"/image_0", "/image_1"}) {
    fs::remove(dir + side + "/000001.png");
    write_image(dir + side + "/000001.jpg", 64, 48, 1);
  }
  EXPECT_TRUE(errors_of(dir, 4).empty());
  test::truncate_file(dir + "/image_1/000001.jpg", 0.9);
  const std::vector<Error> errors = errors_of(dir, 4);
  ASSERT_EQ(errors.size(), 1U);
  test::expect_clear(errors[0], {"image_1/000001.jpg", "torn"});
}

TEST(bad_recording, nothing_readable_at_all) {
  const std::string dir = good(2);
  for (const char* name : {"/image_0/000000.png", "/image_0/000001.png"}) write_file(dir + name, "no image");
  expect_open_error(dir, {"cannot read image", "image_0/000000.png"});
}

TEST(bad_recording, no_times_and_no_rate) {
  const std::string dir = good();
  fs::remove(dir + "/times.txt");
  expect_open_error(dir, {"no times", "--rate", "times.txt"});
  RecordingOptions options;
  options.path = dir;
  options.rate_hz = 5.0;
  EXPECT_TRUE(open_recording(options).ok());
}

TEST(bad_recording, times_that_are_junk) {
  const std::string dir = good();
  const auto with = [&](const std::string& times, const std::vector<std::string>& fragments) {
    write_file(dir + "/times.txt", times);
    expect_open_error(dir, fragments);
  };
  with("0\n0.1\n", {"2 rows for 4 images", "times.txt"});
  with("0\n0.1\n0.2\n0.3\n0.4\n0.5\n", {"6 rows for 4 images", "times.txt"});
  with("0.3\n0.3\n0.3\n0.3\n", {"do not rise", "3 of 4"});
  with("0\nabc\n0.2\n0.4\n", {"no time", "times.txt:2"});
  with("0\nnan\n0.2\n0.4\n", {"no time", "times.txt:2"});
  with("0\n1e99\n0.2\n0.4\n", {"no time", "times.txt:2"});
  with("0\n0.1\n0.2\n20105236816408\n", {"no time", "times.txt:4"});
  with("0\n0.1\n0.2\n99999999999999999999999\n", {"no time", "times.txt:4"});
  with(std::string("0\n\0\n", 4), {"NUL", "times.txt"});
  with("", {"empty", "times.txt"});
  with("\n\n", {"empty", "times.txt"});
}

TEST(bad_recording, a_stamp_that_steps_back_or_repeats_costs_its_pair) {
  for (const auto& [times, why] : std::vector<std::pair<const char*, const char*>>{
           {"0\n0.1\n0.1\n0.3\n", "repeats"}, {"0\n0.1\n0.05\n0.3\n", "steps back by 0.05 s"}}) {
    const std::string dir = good();
    write_file(dir + "/times.txt", times);
    RecordingOptions options;
    options.path = dir;
    auto source = open_recording(options);
    ASSERT_TRUE(source.ok()) << source.error().line();
    StereoPair pair;
    for (int i = 0; i < 4; ++i) {
      const auto more = (*source)->next(pair);
      EXPECT_EQ(pair.index, i);
      EXPECT_EQ(more.ok(), i != 2);
      if (!more.ok()) test::expect_clear(more.error(), {"out of order", "image_0/000002.png", why});
    }
    EXPECT_EQ(pair.stamp_ns, 300'000'000);
  }
}

TEST(bad_recording, dates_that_are_none) {
  const std::string dir = good(2);
  for (const char* row : {"2011-13-26 14:05:37.9", "2011-02-30 14:05:37.9", "2011-09-26 25:05:37",
                          "2011-09-26 14:05:61", "2011-09-26 14:05", "2011-09-26"}) {
    write_file(dir + "/times.txt", std::string("0\n") + row + "\n");
    expect_open_error(dir, {"no time", "times.txt:2"});
  }
}

TEST(bad_recording, calibration_missing_or_of_another_size) {
  std::string dir = good();
  RecordingOptions options;
  options.path = dir;
  options.calibration = dir + "/none.yaml";
  expect_open_error(options, {"no calibration", "none.yaml"});
  options.calibration = write_file(dir + "/camchain.yaml", test::kalibr_yaml(test::make_rig()));
  expect_open_error(options, {"640x480", "64x48", "camchain.yaml"});
  dir = test::scratch_dir();
  write_image(dir + "/left/1700000000000000.png", 64, 48, 0);
  write_image(dir + "/right/1700000000000000.png", 64, 48, 0);
  expect_open_error(dir, {"no calibration", "--calibration"});
  write_file(dir + "/calib.txt", test::kitti_calibration(0.0));
  expect_open_error(dir, {"singular", "calib.txt"});
}

TEST(bad_recording, range_rate_and_tolerance_out_of_bounds) {
  const std::string dir = good();
  const auto with = [&](auto change, const std::vector<std::string>& fragments) {
    RecordingOptions options;
    options.path = dir;
    change(options);
    expect_open_error(options, fragments);
  };
  with([](RecordingOptions& o) { o.first = 4; }, {"first", "pairs 0 to 3"});
  with([](RecordingOptions& o) { o.last = 4; }, {"last", "pairs 0 to 3"});
  with([](RecordingOptions& o) { o.first = -1; }, {"negative"});
  with([](RecordingOptions& o) { o.first = 3, o.last = 1; }, {"before the first"});
  with([](RecordingOptions& o) { o.every = 0; }, {"every"});
  RecordingOptions far;
  far.path = dir;
  far.every = std::numeric_limits<std::int64_t>::max();
  far.first = 1;
  auto source = open_recording(far);
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().frame_count, 1);
  far.pingpong = true;
  source = open_recording(far);
  ASSERT_TRUE(source.ok());
  StereoPair pair;
  for (std::int64_t last = -1; last < 50; last = pair.index) {
    ASSERT_TRUE((*source)->next(pair).ok());
    ASSERT_GT(pair.index, last);
  }
  with([](RecordingOptions& o) { o.rate_hz = 0.0; }, {"rate"});
  with([](RecordingOptions& o) { o.rate_hz = std::numeric_limits<double>::quiet_NaN(); }, {"rate"});
  with([](RecordingOptions& o) { o.pair_tolerance_s = -1.0; }, {"tolerance"});
}

TEST(bad_recording, euroc_list_that_does_not_fit_its_images) {
  const std::string dir = test::scratch_dir();
  for (const bool left : {true, false}) {
    const std::string camera = dir + (left ? "/mav0/cam0" : "/mav0/cam1");
    write_file(camera + "/sensor.yaml", test::euroc_yaml(test::make_rig(), left));
    write_image(camera + "/data/1700000000000000000.png", 640, 480, 0);
    write_image(camera + "/data/1700000000050000000.png", 640, 480, 1);
    write_file(camera + "/data.csv",
               "#timestamp [ns],filename\n1700000000000000000,1700000000000000000.png\n"
               "1700000000050000000,1700000000099000000.png\n");
  }
  RecordingOptions options;
  options.path = dir;
  const auto source = open_recording(options);  // the stamps name the images as well
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().frame_count, 2);
  for (const bool left : {true, false}) {
    write_file(dir + (left ? "/mav0/cam0" : "/mav0/cam1") + "/data.csv",
               "#timestamp [ns],filename\n7,a.png\n8,b.png\n");
  }
  expect_open_error(dir, {"data.csv:2", "a.png"});
}

}  // namespace
}  // namespace cliquevo::drivers
