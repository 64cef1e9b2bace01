// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference.h"

#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "drivers/calibration_file.h"
#include "stereo/rectification.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"
#include "tools/evaluation.h"

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

// The same poses of the body, as VINS-Fusion writes them.
std::string write_vins(const std::string& path, const std::string& euroc_csv) {
  std::ifstream in(euroc_csv);
  std::string text;
  for (std::string line; std::getline(in, line);) {
    if (line.front() == '#') continue;
    std::size_t end = 0;
    for (int i = 0; i < 8; ++i) end = line.find(',', end) + 1;
    text += line.substr(0, end) + "0.1,0.2,0.3,\n";
  }
  return test::write_file(path, text);
}

TEST(Reference, TrajectoriesOfTheSameBodyAreComparedAsTheyAre) {
  const std::string dir = test::scratch_dir();
  const std::string csv = write_euroc_truth(dir);
  const std::string vins = write_vins(dir + "/vio.csv", csv);
  const auto compared = read_compared(csv, vins, false);
  ASSERT_TRUE(compared.ok()) << compared.error().line();
  const auto pairs = associate(compared->reference, compared->estimate, {});
  ASSERT_TRUE(pairs.ok()) << pairs.error().line();
  const Evaluation result = evaluate(*pairs, {});
  EXPECT_LT(result.rpe_m, 1e-9);
  EXPECT_LT(result.end_m, 1e-9);
}

TEST(Reference, PosesOfABodyAreTakenAsTheyAreOnlyWhereTheirAxesAreStated) {
  const std::string dir = test::scratch_dir();
  const std::string csv = write_euroc_truth(dir);
  const std::string vins = write_vins(test::scratch_dir() + "/alone/vio.csv", csv);
  const std::string camera =
      test::write_file(dir + "/camera.tum", "1403636580.0 0 0 0 0 0 0 1\n1403636580.05 0 0 1 0 0 0 1\n");
  const auto refused = read_compared(vins, camera, false);
  ASSERT_FALSE(refused.ok());
  test::expect_clear(refused.error(), {"vio.csv", "VINS-Fusion", "--reference-frame"});
  const auto stated = read_compared(vins, camera, true);
  ASSERT_TRUE(stated.ok()) << stated.error().line();
  EXPECT_TRUE(stated->warnings.empty());
  // As an estimate it is held against a camera's path, and said to be none.
  const auto judged = read_compared(camera, vins, false);
  ASSERT_TRUE(judged.ok()) << judged.error().line();
  ASSERT_EQ(judged->warnings.size(), 1U);
  EXPECT_NE(judged->warnings[0].line().find("VINS-Fusion"), std::string::npos);
}

// TUM VI: mocap0 instead of state_groundtruth_estimate0, and one Kalibr file instead of each camera's sensor.yaml.
TEST(Reference, TumVisMotionCaptureIsARecordingsOwnAndItsCameraIsInTheKalibrFile) {
  const std::string euroc = test::scratch_dir();
  write_euroc_truth(euroc);
  const auto calibration = drivers::read_calibration(euroc + "/mav0/cam0/sensor.yaml", 0, 0);
  ASSERT_TRUE(calibration.ok());
  const std::string dir = test::scratch_dir() + "/room1";
  const RigidTransform T_body_camera{so3_exp({0.2, -1.0, 0.9}), {0.1, -0.05, 0.02}};
  const RigidTransform T_camera_body = T_body_camera.inverse();
  std::string yaml = "cam0:\n  T_cam_imu:\n";
  for (int i = 0; i < 3; ++i) {
    yaml += fmt::format("  - [{:.12f}, {:.12f}, {:.12f}, {:.12f}]\n", T_camera_body.R(i, 0), T_camera_body.R(i, 1),
                        T_camera_body.R(i, 2), T_camera_body.t[i]);
  }
  yaml +=
      "  - [0.0, 0.0, 0.0, 1.0]\n"
      "  camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n"
      "  intrinsics: [400.0, 400.0, 320.0, 240.0]\n  resolution: [640, 480]\n"
      "cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n"
      "  - [0.0, 0.0, 0.0, 1.0]\n"
      "  camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n"
      "  intrinsics: [400.0, 400.0, 320.0, 240.0]\n  resolution: [640, 480]\n";
  test::write_file(dir + "/dso/camchain.yaml", yaml);
  const std::string csv = test::write_file(
      dir + "/mav0/mocap0/data.csv",
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
      "1403636580000000000,1,2,3,1,0,0,0\n1403636580050000000,1,2,4,1,0,0,0\n");
  EXPECT_EQ(reference_beside(dir), csv);
  EXPECT_EQ(reference_beside(dir + "/mav0"), csv);
  // Rectified as they are: nothing turns the camera of such a pair.
  for (const StereoCalibration* given : {static_cast<const StereoCalibration*>(nullptr), &*calibration}) {
    const auto reference = read_reference(csv, given);
    ASSERT_TRUE(reference.ok()) << reference.error().line();
    const Eigen::Vector3d place = reference->poses[0].T_world_camera.t - Eigen::Vector3d(1, 2, 3);
    EXPECT_LT((place - T_body_camera.t).norm(), 1e-9);
    const bool turned = (reference->poses[0].T_world_camera.R - T_body_camera.R).norm() > 1e-9;
    EXPECT_EQ(turned, given != nullptr);
  }
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
