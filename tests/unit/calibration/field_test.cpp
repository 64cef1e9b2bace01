// SPDX-License-Identifier: BSD-3-Clause
// Calibration files as users bring them, with a pair or two of images each: the way from the first image to the second
// checks focal length, baseline and rectification together.
#include <cmath>

#include <fmt/format.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/calibration_file.h"
#include "drivers/recording.h"
#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

constexpr double kRigA_m = 0.08;  // a frame
constexpr double kRigB_m = 0.08;
constexpr double kRigC_m = 0.08;
constexpr double kRigD_m = 0.06;

struct Case {
  std::string folder;
  std::string calibration;
  CalibrationOptions options{};
};

RecordingOptions recording_of(const Case& c) {
  RecordingOptions options;
  options.path = test::field_dir() + "/" + c.folder;
  if (!c.calibration.empty()) options.calibration = options.path + "/" + c.calibration;
  options.calibration_options = c.options;
  return options;
}

void expect_way(const Case& c, double way_m) {
  SCOPED_TRACE(c.folder + "/" + c.calibration);
  auto source = open_recording(recording_of(c));
  ASSERT_TRUE(source.ok()) << source.error().line();
  auto pipeline = daemon::FramePipeline::make({}, (*source)->info());
  ASSERT_TRUE(pipeline.ok()) << pipeline.error().line();
  StereoPair pair;
  int valid = 0;
  for (int frames = 0;; ++frames) {
    const auto more = (*source)->next(pair);
    ASSERT_TRUE(more.ok());
    if (!*more) break;
    ASSERT_TRUE(pipeline->process(pair).ok());
    const vo::Estimate& estimate = pipeline->estimate();
    if (frames == 0) continue;
    EXPECT_EQ(estimate.status, vo::Status::valid) << frames;
    EXPECT_NEAR(estimate.T_world_camera.t.norm() / frames, way_m, 0.02 * way_m) << frames;
    ++valid;
  }
  EXPECT_GE(valid, 1);
}

std::string refusal(const Case& c) {
  auto source = open_recording(recording_of(c));
  EXPECT_FALSE(source.ok()) << c.folder << "/" << c.calibration << " was taken";
  return source.ok() ? "" : source.error().line();
}

std::string notes_of(const Case& c) {
  auto source = open_recording(recording_of(c));
  EXPECT_TRUE(source.ok()) << source.error().line();
  std::string out;
  if (source.ok()) {
    for (const std::string& note : (*source)->info().calibration.notes) out += note + "\n";
  }
  return out;
}

TEST(field, a_baseline_in_squares_of_a_chessboard_is_asked_about) {
  CLIQUEVO_NEEDS_FIELD("05-baseline-in-squares");
  for (const char* file : {"stereo.yml", "stereo_with_P.yml"}) {
    const std::string line = refusal({"05-baseline-in-squares", file});
    EXPECT_NE(line.find("0.1103 m if in squares of 25 mm"), std::string::npos) << line;
    EXPECT_NE(line.find("--baseline-unit 0.025"), std::string::npos) << line;
    CalibrationOptions squares;
    squares.baseline_unit_m = 0.025;
    expect_way({"05-baseline-in-squares", file, squares}, kRigA_m);
  }
}

TEST(field, four_terms_of_a_fisheye_are_seen_by_their_numbers) {
  CLIQUEVO_NEEDS_FIELD("06-opencv-fisheye-4-numbers");
  expect_way({"06-opencv-fisheye-4-numbers", "stereo_named.yml"}, kRigC_m);
  expect_way({"06-opencv-fisheye-4-numbers", "stereo.yml"}, kRigC_m);
  const std::string notes = notes_of({"06-opencv-fisheye-4-numbers", "stereo.yml"});
  EXPECT_NE(notes.find("equidistant"), std::string::npos) << notes;
}

TEST(field, kalibr_chain_with_the_cameras_in_the_imu) {
  CLIQUEVO_NEEDS_FIELD("07-openvins-T_imu_cam");
  expect_way({"07-openvins-T_imu_cam", ""}, kRigA_m);
}

TEST(field, zed_factory_calibration) {
  CLIQUEVO_NEEDS_FIELD("08-zed-conf");
  expect_way({"08-zed-conf", ""}, kRigB_m);
}

TEST(field, opencv_in_xml) {
  CLIQUEVO_NEEDS_FIELD("09-opencv-xml");
  expect_way({"09-opencv-xml", "works.yml"}, kRigA_m);
  expect_way({"09-opencv-xml", "stereo.xml"}, kRigA_m);
}

TEST(field, ros_calibrators_text_for_both_cameras_and_for_one_each) {
  CLIQUEVO_NEEDS_FIELD("10-ros-ost");
  for (const char* file : {"ost.txt", "left.ini", "right.ini"}) expect_way({"10-ros-ost", file}, kRigA_m);
}

TEST(field, orb_slam_settings) {
  CLIQUEVO_NEEDS_FIELD("12-orb-slam");
  for (const char* file : {"orbslam2.yaml", "orbslam3.yaml", "data_nospace.yml"}) {
    expect_way({"12-orb-slam", file}, kRigA_m);
  }
  const auto kitti = read_calibration(test::field_dir() + "/12-orb-slam/orb_kitti.yaml", 640, 400);
  ASSERT_TRUE(kitti.ok()) << kitti.error().line();
  EXPECT_TRUE(kitti->rectified);
  EXPECT_NEAR(kitti->prescribed->model.baseline_m, 0.12, 1e-9);
}

TEST(field, camera_info_with_zeros_where_nothing_was_calibrated) {
  CLIQUEVO_NEEDS_FIELD("14-ros-zero-R");
  expect_way({"14-ros-zero-R", ""}, kRigD_m);
  for (const char* producer : {"ros_gazebo", "ros_gazebo_K0", "ros_zed126"}) {
    expect_way({"14-ros-zero-R", std::string(producer) + "/left.yaml"}, kRigD_m);
  }
  EXPECT_NE(notes_of({"14-ros-zero-R", "ros_zed126/left.yaml"}).find("divided by 1000"), std::string::npos);
  const std::string no_baseline = refusal({"14-ros-zero-R", "ros_P0/left.yaml"});
  EXPECT_NE(no_baseline.find("holds no baseline"), std::string::npos) << no_baseline;
  const auto t265 = read_calibration(test::field_dir() + "/14-ros-zero-R/t265_d5/left.yaml", 848, 800);
  ASSERT_TRUE(t265.ok()) << t265.error().line();
  EXPECT_EQ(t265->left.distortion, Distortion::equidistant);
  EXPECT_NEAR(t265->prescribed->model.baseline_m, 17.69393249 / 282.0199633, 1e-6);
}

TEST(field, rectified_images_with_the_calibration_of_raw_ones_are_noticed) {
  CLIQUEVO_NEEDS_FIELD("16-rectified-images-raw-calibration");
  for (const char* file : {"", "left.yaml"}) {
    const std::string line = refusal({"16-rectified-images-raw-calibration", file});
    EXPECT_NE(line.find("rectified already"), std::string::npos) << line;
    EXPECT_NE(line.find("--rectified"), std::string::npos) << line;
  }
  CalibrationOptions rectified;
  rectified.rectified = true;
  expect_way({"16-rectified-images-raw-calibration", "left.yaml", rectified}, kRigA_m);
}

TEST(field, images_as_grabbed_are_not_taken_for_rectified_ones) {
  CLIQUEVO_NEEDS_FIELD("09-opencv-xml");
  EXPECT_EQ(notes_of({"09-opencv-xml", "works.yml"}), "");
  EXPECT_EQ(notes_of({"08-zed-conf", ""}), "");
}

}  // namespace
}  // namespace cliquevo::drivers
