// SPDX-License-Identifier: BSD-3-Clause
// Recordings are found however their folders and files are named.
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/recording.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/side_words.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;
using test::write_file;
using test::write_image;

// Two paths with {} for the number of a pair: the left image and the right one.
struct Names {
  const char* left;
  const char* right;
};

std::string made(const Names& names, int count = 3) {
  const std::string dir = test::scratch_dir();
  for (int i = 0; i < count; ++i) {
    write_image(dir + "/" + fmt::format(fmt::runtime(names.left), i), 64, 48, 2 * i);
    write_image(dir + "/" + fmt::format(fmt::runtime(names.right), i), 64, 48, 2 * i + 1);
  }
  write_file(dir + "/calib.txt", test::kitti_calibration());
  return dir;
}

// Every pair is of the two images that were written for it.
void expect_pairs(const std::string& path, int count, const std::string& what) {
  RecordingOptions options;
  options.path = path;
  options.rate_hz = 10.0;
  auto source = open_recording(options);
  ASSERT_TRUE(source.ok()) << what << ": " << source.error().line();
  ASSERT_EQ((*source)->info().frame_count, count) << what;
  StereoPair pair;
  for (int i = 0; i < count; ++i) {
    const auto more = (*source)->next(pair);
    ASSERT_TRUE(more.ok()) << what << ": " << more.error().line();
    EXPECT_EQ(pair.left.cview()(0, 0), test::pixel_of(0, 0, 2 * i)) << what << ", pair " << i;
    EXPECT_EQ(pair.right.cview()(0, 0), test::pixel_of(0, 0, 2 * i + 1)) << what << ", pair " << i;
  }
}

TEST(layouts, folders_that_differ_in_what_tells_left_from_right) {
  for (const Names& names : std::vector<Names>{
           {"LEFT/{:04}.png", "RIGHT/{:04}.png"},
           {"Left/{}.png", "Right/{}.png"},
           {"stereo_left/{:04}.png", "stereo_right/{:04}.png"},
           {"left_stereo/{:04}.png", "right_stereo/{:04}.png"},
           {"leftImages/{:04}.png", "rightImages/{:04}.png"},
           {"imgL/{:04}.png", "imgR/{:04}.png"},
           {"L/{:04}.png", "R/{:04}.png"},
           {"cam_l/{:04}.png", "cam_r/{:04}.png"},
           {"Camera_0/{:04}.png", "Camera_1/{:04}.png"},
           {"CAM0/{:04}.png", "CAM1/{:04}.png"},
           {"camera1/{:04}.png", "camera2/{:04}.png"},
           {"infra1/{:04}.png", "infra2/{:04}.png"},
           {"img_2/{:04}.png", "img_3/{:04}.png"},
           {"image_02/{:04}.png", "image_03/{:04}.png"},
           {"0/{:04}.png", "1/{:04}.png"},
           {"cam0/images/{:04}.png", "cam1/images/{:04}.png"},
           {"cam0/image_raw/data/{:04}.png", "cam1/image_raw/data/{:04}.png"},
           {"left/image_raw/{:04}.png", "right/image_raw/{:04}.png"},
           {"left/left_images/{:04}.png", "right/right_images/{:04}.png"},
           {"stereo/left/{:04}.png", "stereo/right/{:04}.png"},
           {"run/data/left/{:04}.png", "run/data/right/{:04}.png"},
           {"undistorted_images/cam0/{:04}.png", "undistorted_images/cam1/{:04}.png"},
           {"train-left-image/2018-07-09/{:04}.png", "train-right-image/2018-07-09/{:04}.png"},
           {"left-image-half-size/{:04}.png", "right-image-half-size/{:04}.png"},
           {"device_0/sensor_0/Infrared_1/image/data/{:04}.png", "device_0/sensor_0/Infrared_2/image/data/{:04}.png"},
           {"left/left_{:04}.png", "right/right_{:04}.png"},
           {"left/frame{:04}_left.png", "right/frame{:04}_right.png"},
           {"links/{:04}.png", "rechts/{:04}.png"},
           {"Kamera_Links/{:04}.png", "Kamera_Rechts/{:04}.png"},
           {"CAM_B/{:04}.png", "CAM_C/{:04}.png"},
           {"camA/{:04}.png", "camB/{:04}.png"},
           {"video0/{:04}.png", "video2/{:04}.png"},
           {"rig/camera_1/{:04}.png", "rig/camera_4/{:04}.png"},
       }) {
    expect_pairs(made(names), 3, names.left);
  }
}

TEST(layouts, both_cameras_in_one_folder) {
  for (const Names& names : std::vector<Names>{
           {"img_{:04}_left.png", "img_{:04}_right.png"},
           {"left{:02}.png", "right{:02}.png"},
           {"Left_{:02}.png", "Right_{:02}.png"},
           {"{:06}_L.png", "{:06}_R.png"},
           {"l_{:06}.png", "r_{:06}.png"},
           {"I1_{:06}.png", "I2_{:06}.png"},
           {"cam0_{:06}.png", "cam1_{:06}.png"},
           {"{:06}_cam0.png", "{:06}_cam1.png"},
           {"Images/img_{:04}_left.png", "Images/img_{:04}_right.png"},
           {"a/b/img_{:04}_left.png", "a/b/img_{:04}_right.png"},
       }) {
    expect_pairs(made(names, 4), 4, names.left);
  }
  expect_pairs(made({"im0.png", "im1.png"}, 1), 1, "im0.png");
}

TEST(layouts, what_lies_beside_the_images_does_not_mislead) {
  std::string dir = made({"image_left/{:04}.png", "image_right/{:04}.png"});
  for (const char* other : {"depth_left", "depth_right", "seg_left", "seg_right", "flow0", "flow1"}) {
    for (int i = 0; i < 3; ++i) write_image(fmt::format("{}/{}/{:04}.png", dir, other, i), 64, 48, 90 + i);
  }
  expect_pairs(dir, 3, "depth and segments");
  dir = made({"undistorted_images/cam0/{:04}.png", "undistorted_images/cam1/{:04}.png"});
  for (const char* other : {"cam0", "cam1"}) {
    for (int i = 0; i < 3; ++i) write_image(fmt::format("{}/distorted_images/{}/{:04}.png", dir, other, i), 64, 48, 90);
  }
  expect_pairs(dir, 3, "distorted and undistorted");
  dir = made({"cam0/{:04}.png", "cam1/{:04}.png"});
  for (int i = 0; i < 3; ++i) write_image(fmt::format("{}/cam2/{:04}.png", dir, i), 64, 48, 90);
  expect_pairs(dir, 3, "a third camera");
}

TEST(layouts, kitti_360_with_its_calibration_beside_the_raw_data) {
  const std::string root = test::scratch_dir();
  const std::string drive = root + "/data_2d_raw/2013_05_28_drive_0000_sync";
  for (int i = 0; i < 3; ++i) {
    for (const char* kind : {"data_rect", "data_rgb"}) {
      write_image(fmt::format("{}/image_00/{}/{:010}.png", drive, kind, i), 600, 420, 2 * i);
      write_image(fmt::format("{}/image_01/{}/{:010}.png", drive, kind, i), 600, 420, 2 * i + 1);
    }
  }
  write_file(root + "/calibration/perspective.txt", test::kitti_raw_txt(test::make_rig()));
  write_file(drive + "/image_00/timestamps.txt",
             "2013-05-28 08:46:02.904048384\n2013-05-28 08:46:03.008048384\n2013-05-28 08:46:03.112048384\n");
  RecordingOptions options;
  options.path = drive;
  const auto source = open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_NE((*source)->info().description.find("KITTI-360"), std::string::npos);
  EXPECT_TRUE((*source)->info().calibration.rectified);
  EXPECT_NEAR((*source)->info().rate_hz, 9.615, 0.01);
}

TEST(layouts, several_recordings_are_not_guessed_among) {
  const std::string dir = test::scratch_dir();
  for (const char* run : {"monday", "tuesday"}) {
    for (const char* side : {"left", "right"}) write_image(fmt::format("{}/{}/{}/0.png", dir, run, side), 64, 48, 0);
  }
  test::expect_open_error(dir, {"several recordings", "monday, tuesday"});
}

TEST(layouts, of_three_sockets_the_stereo_cameras_are_taken) {
  const std::string dir = made({"CAM_B/{:04}.png", "CAM_C/{:04}.png"});
  for (int i = 0; i < 3; ++i) write_image(fmt::format("{}/CAM_A/{:04}.png", dir, i), 64, 48, 50 + i);
  expect_pairs(dir, 3, "CAM_A, CAM_B, CAM_C");
}

TEST(layouts, numbered_runs_and_frames_of_one_camera_are_no_pair) {
  for (const Names& names : std::vector<Names>{{"run1/{:04}.png", "run2/{:04}.png"},
                                               {"seq_00/{:04}.png", "seq_01/{:04}.png"},
                                               {"run1/{:04}.png", "run3/{:04}.png"}}) {
    test::expect_open_error(made(names), {"no stereo recording", "images in"});
  }
  const std::string dir = test::scratch_dir();
  for (int i = 0; i < 5; ++i) write_image(fmt::format("{}/frame{}.png", dir, i), 64, 48, i);
  test::expect_open_error(dir, {"no stereo recording", "5 images in it", "left/right", "--side-by-side"});
}

TEST(layouts, one_side_of_a_nested_pair_is_missing) {
  const std::string dir = test::scratch_dir();
  write_image(dir + "/cams/LEFT/0.png", 64, 48, 0);
  test::expect_open_error(dir, {"right images are missing", "cams/RIGHT"});
}

TEST(side_words, letters_and_numbers_count_where_they_stand_alone) {
  EXPECT_TRUE(pair_kind("imgL", "imgR"));
  EXPECT_TRUE(pair_kind("cam_l_raw", "cam_r_raw"));
  EXPECT_TRUE(pair_kind("LCam", "RCam"));
  EXPECT_FALSE(pair_kind("lab", "rab"));
  EXPECT_FALSE(pair_kind("cam0", "cam2"));
  EXPECT_FALSE(pair_kind("cam9", "cam10"));
  EXPECT_FALSE(pair_kind("run1", "run2"));
  EXPECT_FALSE(pair_kind("right", "left"));
  EXPECT_FALSE(pair_kind("cam0", "image1"));
  EXPECT_FALSE(pair_kind("time1", "time2"));
  EXPECT_EQ(*pair_kind("image_02", "image_03"), kFirstNumberKind + 2);
}

// A textured scene seen from two places, as one picture.
void write_side_by_side(const std::string& path, int seed) {
  cv::Mat scene(120, 260, CV_8UC1);
  cv::RNG rng(static_cast<std::uint64_t>(seed) + 1);
  rng.fill(scene, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(scene, scene, {5, 5}, 1.2);
  cv::Mat both;
  cv::hconcat(scene.colRange(0, 240), scene.colRange(8, 248), both);
  fs::create_directories(fs::path(path).parent_path());
  ASSERT_TRUE(cv::imwrite(path, both));
}

constexpr const char* kHalfsCalibration =
    "P0: 200 0 119.5 0 0 200 59.5 0 0 0 1 0\nP1: 200 0 119.5 -24 0 200 59.5 0 0 0 1 0\n";

TEST(layouts, side_by_side_pictures_are_seen_by_their_halves) {
  for (const char* folder : {"", "/frames"}) {
    const std::string dir = test::scratch_dir();
    for (int i = 0; i < 3; ++i) write_side_by_side(fmt::format("{}{}/{:04}.png", dir, folder, i), i);
    write_file(dir + "/calib.txt", kHalfsCalibration);
    RecordingOptions options;
    options.path = dir;
    options.rate_hz = 10.0;
    const auto source = open_recording(options);
    ASSERT_TRUE(source.ok()) << source.error().line();
    EXPECT_EQ((*source)->info().width, 240);
    EXPECT_NE((*source)->info().description.find("side-by-side"), std::string::npos);
    StereoPair pair;
    ASSERT_TRUE((*source)->next(pair).ok());
    EXPECT_EQ(pair.left.cview()(100, 60), pair.right.cview()(92, 60));
  }
}

TEST(layouts, wide_pictures_whose_halves_do_not_match_are_side_by_side_only_when_told) {
  const std::string dir = test::scratch_dir();
  for (int i = 0; i < 3; ++i) {
    cv::Mat wide(120, 480, CV_8UC1);
    cv::RNG rng(static_cast<std::uint64_t>(i) + 7);
    rng.fill(wide, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(wide, wide, {5, 5}, 1.2);
    ASSERT_TRUE(cv::imwrite(fmt::format("{}/{:04}.png", dir, i), wide));
  }
  write_file(dir + "/calib.txt", kHalfsCalibration);
  RecordingOptions options;
  options.path = dir;
  options.rate_hz = 10.0;
  test::expect_open_error(options, {"no stereo recording", "side-by-side"});
  options.side_by_side = true;
  const auto source = open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().width, 240);
}

TEST(layouts, the_folders_of_the_field) {
  for (const char* name : {"I1-I2", "cam0-images", "one-folder", "stereo-left", "undistorted"}) {
    CLIQUEVO_NEEDS_FIELD(std::string("20-layouts/") + name);
    RecordingOptions options;
    options.path = test::field_dir() + "/20-layouts/" + name;
    // The calibrations beside them are of four times the size.
    options.calibration =
        write_file(test::scratch_dir() + "/calib.txt",
                   "P0: 100 0 79.5 0 0 100 49.5 0 0 0 1 0\nP1: 100 0 79.5 -12 0 100 49.5 0 0 0 1 0\n");
    const auto source = open_recording(options);
    ASSERT_TRUE(source.ok()) << source.error().line();
    EXPECT_EQ((*source)->info().frame_count, 3) << name;
    EXPECT_NEAR((*source)->info().rate_hz, 10.0, 1e-6) << name;
  }
}

}  // namespace
}  // namespace cliquevo::drivers
