// SPDX-License-Identifier: BSD-3-Clause
// Recordings open without options, and play in order.
#include "drivers/recording.h"

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;
using test::write_file;
using test::write_image;

std::unique_ptr<FrameSource> open(const RecordingOptions& options) {
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  return source.ok() ? std::move(*source) : nullptr;
}

std::unique_ptr<FrameSource> open(const std::string& path) {
  RecordingOptions options;
  options.path = path;
  return open(options);
}

struct Played {
  std::vector<TimestampNs> stamps;
  std::vector<std::int64_t> indices;
  std::vector<int> left;  // first pixels
  std::vector<int> right;
  std::vector<std::string> errors;
};

Played play(const std::unique_ptr<FrameSource>& source, int most = 1000) {
  Played played;
  if (!source) return played;  // reported where it was opened
  StereoPair pair;
  for (int i = 0; i < most; ++i) {
    const Result<bool> more = source->next(pair);
    if (more.ok() && !*more) break;
    played.stamps.push_back(pair.stamp_ns);
    played.indices.push_back(pair.index);
    played.left.push_back(more.ok() ? pair.left.cview()(0, 0) : -1);
    played.right.push_back(more.ok() ? pair.right.cview()(0, 0) : -1);
    if (!more.ok()) played.errors.push_back(more.error().line());
  }
  return played;
}

using Stamps = std::vector<TimestampNs>;

TEST(recording, kitti_odometry_folder) {
  auto source = open(test::write_kitti_odometry(test::scratch_dir(), 4));
  ASSERT_TRUE(source);
  const SourceInfo& info = source->info();
  EXPECT_NE(info.description.find("KITTI odometry"), std::string::npos);
  EXPECT_EQ(info.width, 64);
  EXPECT_EQ(info.height, 48);
  EXPECT_EQ(info.frame_count, 4);
  EXPECT_DOUBLE_EQ(info.rate_hz, 10.0);
  EXPECT_TRUE(info.calibration.rectified);
  EXPECT_TRUE(info.left_mask.empty());
  const Played played = play(source);
  EXPECT_EQ(played.stamps, (Stamps{0, 100'000'000, 200'000'000, 300'000'000}));
  EXPECT_EQ(played.indices, (std::vector<std::int64_t>{0, 1, 2, 3}));
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(played.left[static_cast<std::size_t>(i)], test::pixel_of(0, 0, 2 * i));
    EXPECT_EQ(played.right[static_cast<std::size_t>(i)], test::pixel_of(0, 0, 2 * i + 1));
  }
}

TEST(recording, grey_images_arrive_exactly) {
  auto source = open(test::write_kitti_odometry(test::scratch_dir(), 1));
  ASSERT_TRUE(source);
  StereoPair pair;
  const Result<bool> more = source->next(pair);
  ASSERT_TRUE(more.ok() && *more);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) ASSERT_EQ(pair.right.cview()(x, y), test::pixel_of(x, y, 1));
  }
}

TEST(recording, colour_becomes_grey_by_the_usual_weights) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 1);
  const int b = 200;
  const int g = 90;
  const int r = 30;
  test::write_colour_image(dir + "/image_0/000000.png", 64, 48, b, g, r);
  test::write_colour_image(dir + "/image_1/000000.png", 64, 48, 0, 0, 255);
  auto source = open(dir);
  ASSERT_TRUE(source);
  StereoPair pair;
  ASSERT_TRUE(source->next(pair).ok());
  EXPECT_NEAR(pair.left.cview()(5, 5), 0.114 * b + 0.587 * g + 0.299 * r, 1.0);
  EXPECT_NEAR(pair.right.cview()(5, 5), 0.299 * 255, 1.0);
}

TEST(recording, kitti_raw_drive_with_the_days_calibration_above_it) {
  const std::string day = test::scratch_dir();
  const std::string drive = day + "/drive_0001";
  write_file(day + "/calib_cam_to_cam.txt", test::kitti_raw_txt(test::make_rig()));
  std::string times;
  for (int i = 0; i < 3; ++i) {
    write_image(fmt::format("{}/image_00/data/{:010}.png", drive, i), 640, 480, i);
    write_image(fmt::format("{}/image_01/data/{:010}.png", drive, i), 640, 480, i + 10);
    times += fmt::format("2011-09-26 23:59:5{}.500000001\n", 7 + i);
  }
  write_file(drive + "/image_00/timestamps.txt", times);
  write_file(drive + "/image_01/timestamps.txt",
             "2011-09-26 23:59:57.9\n2011-09-26 23:59:58.9\n2011-09-26 23:59:59.9\n");
  for (const std::string& path : {drive, drive + "/"}) {
    auto source = open(path);
    ASSERT_TRUE(source);
    EXPECT_FALSE(source->info().calibration.rectified);
    EXPECT_TRUE(source->info().calibration.prescribed);
    EXPECT_DOUBLE_EQ(source->info().rate_hz, 1.0);
    // Stamps of the left camera, though the right's are 0.4 s later: the same names belong together.
    EXPECT_EQ(play(source).stamps, (Stamps{1317081597500000001, 1317081598500000001, 1317081599500000001}));
  }
}

TEST(recording, euroc_folder_or_its_mav0) {
  const std::string dir = test::scratch_dir();
  for (const bool left : {true, false}) {
    const std::string camera = dir + (left ? "/mav0/cam0" : "/mav0/cam1");
    write_file(camera + "/sensor.yaml", test::euroc_yaml(test::make_rig(), left));
    std::string csv = "#timestamp [ns],filename\r\n";
    for (int i = 0; i < 3; ++i) {
      const std::string name = std::to_string(1403636579763555584 + i * 50'000'000LL);
      write_image(camera + "/data/" + name + ".png", 640, 480, i);
      csv += name + "," + name + ".png\r\n";
    }
    write_file(camera + "/data.csv", csv);
  }
  for (const std::string& path : {dir, dir + "/mav0"}) {
    auto source = open(path);
    ASSERT_TRUE(source);
    EXPECT_NE(source->info().description.find("EuRoC"), std::string::npos);
    EXPECT_NEAR(source->info().rate_hz, 20.0, 1e-9);
    EXPECT_FALSE(source->info().calibration.rectified);
    EXPECT_EQ(play(source).stamps, (Stamps{1403636579763555584, 1403636579813555584, 1403636579863555584}));
  }
  fs::remove(dir + "/mav0/cam0/data.csv");  // the names will do
  EXPECT_EQ(play(open(dir)).stamps.front(), 1403636579763555584);
}

// The rig with its right camera first: as cam0 of a EuRoC folder, and of a Kalibr chain for two folders of these names.
std::string folder_with_the_right_camera_first(const std::string& layout, const char* first, const char* second) {
  const std::string dir = test::scratch_dir() + "/" + layout;
  const test::Rig rig = test::make_rig();
  test::Rig turned = rig;
  std::swap(turned.K_left, turned.K_right);
  std::swap(turned.D_left, turned.D_right);
  turned.T_right_left = rig.T_right_left.inverse();
  for (const bool is_first : {true, false}) {
    const std::string camera = dir + "/" + (is_first ? first : second);
    if (layout == "euroc") write_file(camera + "/sensor.yaml", test::euroc_yaml(turned, is_first));
    for (const char* name : {"1403636579763555584.png", "1403636579813555584.png"}) {
      write_image(camera + (layout == "euroc" ? "/data/" : "/") + name, 640, 480, is_first ? 1 : 2);
    }
  }
  if (layout != "euroc") write_file(dir + "/camchain.yaml", test::kalibr_yaml(turned));
  return dir;
}

std::string first_pair_seeds(const drivers::RecordingOptions& options) {
  auto source = drivers::open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  if (!source.ok()) return {};
  EXPECT_LT((*source)->info().calibration.T_right_left.t.x(), 0.0);
  drivers::StereoPair pair;
  EXPECT_TRUE(*(*source)->next(pair));
  const auto seed = [](const Image<std::uint8_t>& image) {
    return image.cview()(7, 5) == test::pixel_of(7, 5, 1) ? "1" : "2";
  };
  return std::string(seed(pair.left)) + seed(pair.right);
}

TEST(recording, numbered_images_follow_a_calibration_whose_first_camera_is_the_right_one) {
  drivers::RecordingOptions options;
  options.path = folder_with_the_right_camera_first("euroc", "mav0/cam0", "mav0/cam1");
  EXPECT_EQ(first_pair_seeds(options), "21");
  options.path = folder_with_the_right_camera_first("kalibr", "cam0", "cam1");
  EXPECT_EQ(first_pair_seeds(options), "21");
  options.order_stated = true;  // --swap-eyes exchanges them
  EXPECT_EQ(first_pair_seeds(options), "12");
}

TEST(recording, images_named_left_and_right_are_what_they_are_called) {
  drivers::RecordingOptions options;
  options.path = folder_with_the_right_camera_first("named", "left", "right");
  EXPECT_EQ(first_pair_seeds(options), "12");
}

// Two folders named `left` and `right` with these names of images, and a calibration.
std::string two_folders(const std::vector<std::string>& left, const std::vector<std::string>& right,
                        const char* left_folder = "left", const char* right_folder = "right") {
  const std::string dir = test::scratch_dir();
  int seed = 0;
  for (const std::string& name : left) write_image(fmt::format("{}/{}/{}", dir, left_folder, name), 64, 48, seed++);
  seed = 100;
  for (const std::string& name : right) write_image(fmt::format("{}/{}/{}", dir, right_folder, name), 64, 48, seed++);
  write_file(dir + "/calib.txt", test::kitti_calibration());
  return dir;
}

TEST(recording, two_folders_by_many_names) {
  for (const auto& [left, right] : std::vector<std::pair<const char*, const char*>>{{"left", "right"},
                                                                                    {"image_0", "image_1"},
                                                                                    {"cam0", "cam1"},
                                                                                    {"Left", "Right"},
                                                                                    {"infra1", "infra2"},
                                                                                    {"left_images", "right_images"},
                                                                                    {"cam0/data", "cam1/data"},
                                                                                    {"image_2", "image_3"}}) {
    const std::string dir = two_folders({"1.pgm", "2.pgm"}, {"1.pgm", "2.pgm"}, left, right);
    write_file(dir + "/calibration.txt", "Pinhole 100 100 31.5 23.5 0\n64 48\ncrop\n64 48\n0.5\n");
    RecordingOptions options;
    options.path = dir;
    options.rate_hz = 10.0;
    options.calibration = dir + "/calibration.txt";
    auto source = open(options);
    ASSERT_TRUE(source) << left;
    EXPECT_EQ(play(source).stamps, (Stamps{0, 100'000'000}));
  }
}

TEST(recording, names_that_are_times) {
  EXPECT_EQ(play(open(two_folders({"1687709319100414.png", "1687709319167157.png"},
                                  {"1687709319100414.png", "1687709319167157.png"})))
                .stamps,
            (Stamps{1687709319100414000, 1687709319167157000}));
  EXPECT_EQ(play(open(two_folders({"1403636579763555584.png", "1403636579813555584.png"},
                                  {"1403636579763555584.png", "1403636579813555584.png"})))
                .stamps,
            (Stamps{1403636579763555584, 1403636579813555584}));
  EXPECT_EQ(play(open(two_folders({"1687709319.100414.png", "1687709319.2.png"},
                                  {"1687709319.100414.png", "1687709319.2.png"})))
                .stamps,
            (Stamps{1687709319100414000, 1687709319200000000}));
}

TEST(recording, times_files_in_each_spelling) {
  const auto stamps_with = [](const std::string& file, const std::string& text) {
    const std::string dir = two_folders({"8.png", "9.png", "10.png"}, {"8.png", "9.png", "10.png"});
    write_file(dir + "/" + file, text);
    return play(open(dir)).stamps;
  };
  EXPECT_EQ(stamps_with("times.txt", "0.5\n1.25e0\n2\n"), (Stamps{500'000'000, 1'250'000'000, 2'000'000'000}));
  EXPECT_EQ(stamps_with("times.txt", "# time\n1687709319.123456789\n\n1687709320\n1687709321\n"),
            (Stamps{1687709319123456789, 1687709320000000000, 1687709321000000000}));
  EXPECT_EQ(stamps_with("timestamps.txt", "1687709319000001\n1687709319000002\n1687709319000003\n"),
            (Stamps{1687709319000001000, 1687709319000002000, 1687709319000003000}));
  EXPECT_EQ(stamps_with("times.txt", "8 1.0 0.01\n9 2.0 0.01\n10 3.0 0.01\n"),
            (Stamps{1'000'000'000, 2'000'000'000, 3'000'000'000}));
  EXPECT_EQ(stamps_with("times.txt", "1.0 left/8.png\n2.0 left/9.png\n3.0 left/10.png\n"),
            (Stamps{1'000'000'000, 2'000'000'000, 3'000'000'000}));
}

TEST(recording, names_sort_as_numbers) {
  const std::string dir =
      two_folders({"img_2.png", "img_10.png", "img_1.png"}, {"img_1.png", "img_10.png", "img_2.png"});
  RecordingOptions options;
  options.path = dir;
  options.rate_hz = 1.0;
  const Played played = play(open(options));
  ASSERT_EQ(played.left.size(), 3U);
  EXPECT_EQ(played.left, (std::vector<int>{test::pixel_of(0, 0, 2), test::pixel_of(0, 0, 0), test::pixel_of(0, 0, 1)}));
}

TEST(recording, other_names_pair_by_time_within_a_quarter_period) {
  // 100 ms period; the third right image is 30 ms off, the left has one more at the end.
  const std::string dir = two_folders(
      {"1700000000000000000.png", "1700000000100000000.png", "1700000000200000000.png", "1700000000300000000.png"},
      {"1700000000003000000.png", "1700000000090000000.png", "1700000000230000000.png"});
  RecordingOptions options;
  options.path = dir;
  auto source = open(options);
  ASSERT_TRUE(source);
  EXPECT_NE(source->info().description.find("3 images without a partner"), std::string::npos);
  Played played = play(source);
  EXPECT_EQ(played.stamps, (Stamps{1700000000000000000, 1700000000100000000}));
  EXPECT_EQ(played.right, (std::vector<int>{test::pixel_of(0, 0, 100), test::pixel_of(0, 0, 101)}));
  options.pair_tolerance_s = 0.04;
  EXPECT_EQ(play(open(options)).stamps.size(), 3U);
  options.pair_tolerance_s = 0.005;
  EXPECT_EQ(play(open(options)).stamps.size(), 1U);
  options.pair_tolerance_s = 0.001;
  test::expect_open_error(options, {"no image of the left camera is within 0.001 s", "--pair-tolerance"});
}

TEST(recording, names_that_differ_in_the_camera_only_pair_by_their_number) {
  const std::string dir = two_folders({"left_08.png", "left_09.png"}, {"right_08.png", "right_09.png"});
  RecordingOptions options;
  options.path = dir;
  options.rate_hz = 30.0;
  EXPECT_EQ(play(open(options)).stamps, (Stamps{0, 33333333}));
}

TEST(recording, part_of_a_recording) {
  RecordingOptions options;
  options.path = test::write_kitti_odometry(test::scratch_dir(), 8);
  options.first = 1;
  options.last = 6;
  options.every = 2;
  auto source = open(options);
  ASSERT_TRUE(source);
  EXPECT_EQ(source->info().frame_count, 3);
  EXPECT_DOUBLE_EQ(source->info().rate_hz, 5.0);
  const Played played = play(source);
  EXPECT_EQ(played.indices, (std::vector<std::int64_t>{1, 3, 5}));
  EXPECT_EQ(played.stamps, (Stamps{100'000'000, 300'000'000, 500'000'000}));
}

TEST(recording, ping_pong_goes_on_forward_and_backward_with_rising_stamps) {
  RecordingOptions options;
  options.path = test::write_kitti_odometry(test::scratch_dir(), 3);
  options.pingpong = true;
  auto source = open(options);
  ASSERT_TRUE(source);
  EXPECT_EQ(source->info().frame_count, -1);
  const Played played = play(source, 8);
  std::vector<int> expected;
  for (const int i : {0, 1, 2, 1, 0, 1, 2, 1}) expected.push_back(test::pixel_of(0, 0, 2 * i));
  EXPECT_EQ(played.left, expected);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(played.stamps[k], static_cast<std::int64_t>(k) * 100'000'000);
    EXPECT_EQ(played.indices[k], static_cast<std::int64_t>(k));
  }
}

TEST(recording, reading_ahead_changes_nothing) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 12);
  test::truncate_file(dir + "/image_1/000004.png", 0.5);
  fs::remove(dir + "/image_0/000009.png");
  fs::create_symlink("nowhere.png", dir + "/image_0/000009.png");
  RecordingOptions options;
  options.path = dir;
  const Played ahead = play(open(options));
  options.read_ahead = false;
  const Played plain = play(open(options));
  EXPECT_EQ(ahead.stamps, plain.stamps);
  EXPECT_EQ(ahead.indices, plain.indices);
  EXPECT_EQ(ahead.left, plain.left);
  EXPECT_EQ(ahead.right, plain.right);
  EXPECT_EQ(ahead.errors, plain.errors);
  EXPECT_EQ(ahead.errors.size(), 2U);
  EXPECT_EQ(ahead.stamps.size(), 12U);
}

TEST(recording, closing_it_in_the_middle_does_not_hang) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 6);
  for (int taken = 0; taken < 6; ++taken) {
    auto source = open(dir);
    EXPECT_EQ(play(source, taken).stamps.size(), static_cast<std::size_t>(taken));
  }
}

TEST(recording, its_end_stays_its_end) {
  auto source = open(test::write_kitti_odometry(test::scratch_dir(), 2));
  EXPECT_EQ(play(source).stamps.size(), 2U);
  StereoPair pair;
  for (int i = 0; i < 3; ++i) {
    const Result<bool> more = source->next(pair);
    ASSERT_TRUE(more.ok());
    EXPECT_FALSE(*more);
  }
}

TEST(recording, masks_in_it_or_given) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 2);
  write_image(dir + "/mask_left.png", 64, 48, 3);
  RecordingOptions options;
  options.path = dir;
  auto source = open(options);
  ASSERT_TRUE(source);
  ASSERT_TRUE(source->info().left_mask.cview().same_size(64, 48));
  EXPECT_EQ(source->info().left_mask.cview()(7, 9), test::pixel_of(7, 9, 3));
  EXPECT_TRUE(source->info().right_mask.empty());
  options.right_mask = dir + "/elsewhere.png";
  test::expect_open_error(options, {"cannot read mask", "elsewhere.png"});
  write_image(options.right_mask, 64, 48, 4);
  EXPECT_FALSE(open(options)->info().right_mask.empty());
  write_image(options.right_mask, 32, 48, 4);
  test::expect_open_error(options, {"mask", "32x48", "64x48", "elsewhere.png"});
}

}  // namespace
}  // namespace cliquevo::drivers
