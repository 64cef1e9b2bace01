// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference.h"

#include <filesystem>

#include <fmt/format.h>

#include "drivers/calibration_file.h"
#include "stereo/rectification.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::tools {
namespace {

namespace fs = std::filesystem;

RigidTransform pose_of(int i) {
  return {so3_exp({0.01 * i, -0.3 + 0.02 * i, 0.005 * i}), {0.1 * i, 0.02 * i * i, 1.0 - 0.03 * i}};
}

// A EuRoC recording's calibration, and the ground truth of its body for these poses of the rectified left camera.
std::string write_euroc_truth(const std::string& dir) {
  const test::Rig rig = test::make_rig();
  for (const bool left : {true, false}) {
    test::write_file(dir + (left ? "/mav0/cam0" : "/mav0/cam1") + "/sensor.yaml", test::euroc_yaml(rig, left));
  }
  const auto calibration = drivers::read_calibration(dir + "/mav0/cam0/sensor.yaml", 0, 0);
  EXPECT_TRUE(calibration.ok());
  const auto rectification = stereo::choose_rectification(*calibration);
  EXPECT_TRUE(rectification.ok());
  const RigidTransform T_body_camera{so3_exp({0.1, -1.2, 1.1}), {0.3, -0.1, 0.05}};  // as euroc_yaml() has it
  const RigidTransform T_camera_rectified{rectification->R_left.transpose(), Eigen::Vector3d::Zero()};
  const RigidTransform T_body_rectified = T_body_camera * T_camera_rectified;
  std::string csv = "#timestamp, p_RS_R_x [m], ...\n";
  for (int i = 0; i < 30; ++i) {
    const RigidTransform T = pose_of(i) * T_body_rectified.inverse();
    const Eigen::Quaterniond q(T.R);
    csv += fmt::format("{},{:.15g},{:.15g},{:.15g},{:.15g},{:.15g},{:.15g},{:.15g},0,0,0,0,0,0,0,0,0\n",
                       1'403'636'580'000'000'000 + i * 50'000'000LL, T.t.x(), T.t.y(), T.t.z(), q.w(), q.x(), q.y(),
                       q.z());
  }
  return test::write_file(dir + "/mav0/state_groundtruth_estimate0/data.csv", csv);
}

TEST(Reference, EurocGroundTruthOfTheBodyBecomesPosesOfTheRectifiedLeftCamera) {
  const std::string dir = test::scratch_dir();
  const std::string csv = write_euroc_truth(dir);
  const auto reference = read_reference(csv);
  ASSERT_TRUE(reference.ok()) << reference.error().line();
  ASSERT_EQ(reference->poses.size(), 30U);
  for (int i = 0; i < 30; ++i) {
    const RigidTransform off = pose_of(i).inverse() * reference->poses[static_cast<std::size_t>(i)].T_world_camera;
    EXPECT_LT(off.t.norm(), 1e-9) << i;
    EXPECT_LT(off.angle(), 1e-7) << i;
  }
  EXPECT_EQ(reference_beside(dir), csv);
  EXPECT_EQ(reference_beside(dir + "/mav0"), dir + "/mav0/state_groundtruth_estimate0/data.csv");
}

TEST(Reference, TheGroundTruthsOwnSensorMayBeMountedElsewhere) {
  const std::string dir = test::scratch_dir();
  const std::string csv = write_euroc_truth(dir);
  test::write_file(dir + "/mav0/state_groundtruth_estimate0/sensor.yaml",
                   "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
  const auto reference = read_reference(csv);
  ASSERT_TRUE(reference.ok()) << reference.error().line();
  const RigidTransform off = pose_of(3).inverse() * reference->poses[3].T_world_camera;
  EXPECT_NEAR(off.t.norm(), 0.5, 1e-9);
}

TEST(Reference, EurocGroundTruthWithoutItsCameraIsRefusedByName) {
  const std::string dir = test::scratch_dir();
  const std::string csv = write_euroc_truth(dir);
  test::write_file(dir + "/mav0/cam0/sensor.yaml", "T_BS: none\n");
  auto reference = read_reference(csv);
  ASSERT_FALSE(reference.ok());
  test::expect_clear(reference.error(), {"data.csv", "cam0/sensor.yaml"});
  fs::remove(dir + "/mav0/cam0/sensor.yaml");
  reference = read_reference(csv);
  ASSERT_FALSE(reference.ok());
  test::expect_clear(reference.error(), {"data.csv", "cam0/sensor.yaml"});
}

TEST(Reference, Kitti360sPosesAreFoundBesideTheRawDataAndMatchedByNumber) {
  const std::string root = test::scratch_dir();
  const std::string drive = root + "/data_2d_raw/2013_05_28_drive_0000_sync";
  fs::create_directories(drive);
  std::string text;
  for (int number = 100; number < 130; number += 2) {
    text += fmt::format("{} 1 0 0 {} 0 1 0 0 0 0 1 0 0 0 0 1\n", number, number);
  }
  const std::string poses = test::write_file(root + "/data_poses/2013_05_28_drive_0000_sync/cam0_to_world.txt", text);
  EXPECT_EQ(reference_beside(drive), poses);
  std::vector<FrameRecord> frames(10);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].index = static_cast<std::int64_t>(i);
  drivers::SourceInfo info;
  info.first_number = 101;
  const auto reference = reference_from_file(poses, frames, info);
  ASSERT_TRUE(reference.ok()) << reference.error().line();
  ASSERT_EQ(reference->pairs.size(), 5U);
  EXPECT_EQ(reference->pairs[0].estimate_index, 1U);
  EXPECT_EQ(reference->pairs[0].reference.t.x(), 102.0);
  info.first_number = 500;
  EXPECT_FALSE(reference_from_file(poses, frames, info).ok());
}

// The camera looks along the vehicle's x, 1.5 m before its navigation unit; R_rect_00 turns it a little.
TEST(Reference, Kitti360sVehiclePosesBecomeTheRectifiedCameras) {
  const std::string root = test::scratch_dir();
  const std::string poses = test::write_file(root + "/data_poses/drive/poses.txt",
                                             "7 1 0 0 10 0 1 0 20 0 0 1 0\n"
                                             "8 0 -1 0 11 1 0 0 20 0 0 1 0\n");
  auto reference = read_reference(poses);
  ASSERT_FALSE(reference.ok());
  test::expect_clear(reference.error(), {"poses.txt", "calib_cam_to_pose.txt", "cam0_to_world.txt"});

  test::write_file(root + "/calibration/calib_cam_to_pose.txt",
                   "image_00: 0 0 1 1.5 -1 0 0 0 0 -1 0 0\nimage_01: 0 0 1 1.5 -1 0 0 0.6 0 -1 0 0\n");
  test::write_file(root + "/calibration/perspective.txt", "R_rect_00: 0.9999995 0 0.001 0 1 0 -0.001 0 0.9999995\n");
  reference = read_reference(poses);
  ASSERT_TRUE(reference.ok()) << reference.error().line();
  ASSERT_EQ(reference->poses.size(), 2U);
  EXPECT_TRUE(reference->numbered);
  EXPECT_EQ(reference->poses[0].frame, 7);
  const RigidTransform& first = reference->poses[0].T_world_camera;
  EXPECT_NEAR((first.t - Eigen::Vector3d(11.5, 20.0, 0.0)).norm(), 0.0, 1e-9);
  // Its optical axis: z of the rectified camera, in the unrectified one's axes the last row of R_rect.
  EXPECT_NEAR((first.R.col(2) - Eigen::Vector3d(0.9999995, 0.001, 0.0)).norm(), 0.0, 1e-9);
  // The vehicle has turned to the left: the camera is mounted before it.
  EXPECT_NEAR((reference->poses[1].T_world_camera.t - Eigen::Vector3d(11.0, 21.5, 0.0)).norm(), 0.0, 1e-9);
  fs::create_directories(root + "/data_2d_raw/drive");
  EXPECT_EQ(reference_beside(root + "/data_2d_raw/drive"), poses);

  test::write_file(root + "/calibration/perspective.txt", "R_rect_00: 1 0 0 0 1 0 0 0 nan\n");
  reference = read_reference(poses);
  ASSERT_FALSE(reference.ok());
  test::expect_clear(reference.error(), {"calibration", "R_rect_00"});
}

}  // namespace
}  // namespace cliquevo::tools
