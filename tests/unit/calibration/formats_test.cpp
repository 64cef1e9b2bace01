// SPDX-License-Identifier: BSD-3-Clause
// Calibrations as other programs and data sets write them, each in a small file of its own.
#include <filesystem>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::list_of;
using test::write_file;

StereoCalibration read(const std::string& path, int width = 640, int height = 480,
                       const CalibrationOptions& options = {}) {
  const auto c = read_calibration(path, width, height, options);
  EXPECT_TRUE(c.ok()) << c.error().line();
  return c.ok() ? *c : StereoCalibration{};
}

RigidTransform pose() { return {so3_exp({0.01, -0.02, 0.005}), {-0.12, 0.001, -0.002}}; }
RigidTransform body() { return {so3_exp({0.7, -0.4, 1.1}), {0.05, -0.02, 0.4}}; }

void expect_pose(const StereoCalibration& c) {
  EXPECT_LT((c.T_right_left.R - pose().R).norm(), 1e-6);
  EXPECT_LT((c.T_right_left.t - pose().t).norm(), 1e-6);
}

std::string matrix4(const RigidTransform& T) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = T.R;
  m.topRightCorner<3, 1>() = T.t;
  return list_of(m);
}

std::string kalibr(const std::string& model, const std::string& intrinsics, const std::string& distortion,
                   const std::string& D) {
  const RigidTransform T_imu_left = body();
  const RigidTransform T_imu_right = body() * pose().inverse();
  std::string out = "%YAML:1.0\n";
  for (const bool left : {true, false}) {
    out += fmt::format(
        "cam{}:\n  T_imu_cam: [{}]\n  camera_model: {}\n  intrinsics: [{}]\n  distortion_model: {}\n"
        "  distortion_coeffs: [{}]\n  resolution: [640, 480]\n",
        left ? 0 : 1, matrix4(left ? T_imu_left : T_imu_right), model, intrinsics, distortion, D);
  }
  return out;
}

TEST(formats, kalibr_models_with_poses_in_the_imu) {
  const std::string dir = test::scratch_dir();
  const auto ds =
      read(write_file(dir + "/kalibr_imucam_chain.yaml", kalibr("ds", "-0.2, 0.58, 280, 281, 320, 240", "none", "")));
  EXPECT_EQ(ds.left.distortion, Distortion::double_sphere);
  EXPECT_DOUBLE_EQ(ds.left.coefficients[0], -0.2);
  EXPECT_DOUBLE_EQ(ds.left.coefficients[1], 0.58);
  EXPECT_DOUBLE_EQ(ds.left.fy_px, 281.0);
  expect_pose(ds);
  const auto eucm = read(write_file(dir + "/a.yaml", kalibr("eucm", "0.6, 1.1, 300, 300, 320, 240", "none", "")));
  EXPECT_EQ(eucm.right.distortion, Distortion::extended_unified);
  EXPECT_DOUBLE_EQ(eucm.right.coefficients[1], 1.1);
  const auto omni = read(
      write_file(dir + "/b.yaml", kalibr("omni", "1.2, 700, 700, 320, 240", "radtan", "-0.1, 0.02, 0.001, -0.002")));
  EXPECT_EQ(omni.left.distortion, Distortion::unified);
  EXPECT_DOUBLE_EQ(omni.left.coefficients[0], 1.2);
  EXPECT_DOUBLE_EQ(omni.left.coefficients[4], -0.002);
  EXPECT_DOUBLE_EQ(omni.left.fx_px, 700.0);
  expect_pose(omni);
}

TEST(formats, okvis_list_of_cameras) {
  std::string text = "%YAML:1.0\ncameras:\n";
  for (const RigidTransform& T : {body(), body() * pose().inverse()}) {
    text += fmt::format(
        "     - {{T_SC:\n        [{}],\n        image_dimension: [640, 480],\n        "
        "distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002],\n        distortion_type: "
        "radialtangential,\n        focal_length: [458.6, 457.3],\n        principal_point: [310.2, "
        "248.4]}}\n",
        matrix4(T));
  }
  const auto c = read(write_file(test::scratch_dir() + "/config.yaml", text));
  EXPECT_EQ(c.left.distortion, Distortion::plumb_bob);
  EXPECT_DOUBLE_EQ(c.left.fy_px, 457.3);
  EXPECT_DOUBLE_EQ(c.right.cx_px, 310.2);
  expect_pose(c);
}

TEST(formats, vins_fusion_in_three_files) {
  const std::string dir = test::scratch_dir();
  const auto matrix = [](const char* key, const RigidTransform& T) {
    return fmt::format("{}: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [{}]\n", key, matrix4(T));
  };
  const std::string path =
      write_file(dir + "/rig.yaml",
                 "%YAML:1.0\nimu: 1\nnum_of_cam: 2\ncam0_calib: \"left_mei.yaml\"\n"
                 "cam1_calib: \"right_mei.yaml\"\nimage_width: 640\nimage_height: 480\n" +
                     matrix("body_T_cam0", body()) + matrix("body_T_cam1", body() * pose().inverse()));
  const std::string mei =
      "%YAML:1.0\n---\nmodel_type: MEI\ncamera_name: camera\nimage_width: 640\nimage_height: 480\nmirror_parameters:\n"
      "   xi: 1.5\ndistortion_parameters:\n   k1: -0.05\n   k2: 0.1\n   p1: 0.001\n   p2: 0.002\n"
      "projection_parameters:\n   gamma1: 800\n   gamma2: 801\n   u0: 322\n   v0: 241\n";
  write_file(dir + "/left_mei.yaml", mei);
  EXPECT_FALSE(read_calibration(path, 640, 480).ok());  // the right one is missing
  write_file(dir + "/right_mei.yaml", mei);
  const auto c = read(path);
  EXPECT_EQ(c.left.distortion, Distortion::unified);
  EXPECT_DOUBLE_EQ(c.left.coefficients[1], -0.05);
  EXPECT_DOUBLE_EQ(c.left.fy_px, 801.0);
  expect_pose(c);
  write_file(dir + "/left_mei.yaml",
             "%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\nimage_width: 640\nimage_height: 480\n"
             "projection_parameters:\n   k2: 0.01\n   k3: 0.02\n   k4: -0.03\n   k5: 0.004\n   mu: 300\n   mv: 301\n"
             "   u0: 322\n   v0: 241\n");
  EXPECT_EQ(read(path).left.distortion, Distortion::equidistant);
  EXPECT_DOUBLE_EQ(read(path).left.coefficients[3], 0.004);
}

std::string basalt(const std::string& type, const std::string& terms) {
  std::string poses, cameras;
  for (const RigidTransform& T : {body(), body() * pose().inverse()}) {
    const Eigen::Quaterniond q(T.R);
    poses += fmt::format("{}{{\"px\": {}, \"py\": {}, \"pz\": {}, \"qx\": {}, \"qy\": {}, \"qz\": {}, \"qw\": {}}}",
                         poses.empty() ? "" : ", ", T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w());
    cameras += fmt::format(
        "{}{{\"camera_type\": \"{}\", \"intrinsics\": {{\"fx\": 280.0, \"fy\": 281.0, \"cx\": 320.0, "
        "\"cy\": 240.0, {}}}}}",
        cameras.empty() ? "" : ", ", type, terms);
  }
  return fmt::format(
      "{{\n  \"value0\": {{\n    \"T_imu_cam\": [{}],\n    \"intrinsics\": [{}],\n    \"resolution\": "
      "[[640, 480], [640, 480]]\n  }}\n}}\n",
      poses, cameras);
}

TEST(formats, basalt_json) {
  const std::string dir = test::scratch_dir();
  const auto ds = read(write_file(dir + "/ds.json", basalt("ds", "\"xi\": -0.2, \"alpha\": 0.58")));
  EXPECT_EQ(ds.left.distortion, Distortion::double_sphere);
  EXPECT_DOUBLE_EQ(ds.right.coefficients[1], 0.58);
  expect_pose(ds);
  const auto kb4 =
      read(write_file(dir + "/kb.json", basalt("kb4", "\"k1\": 0.01, \"k2\": 0.02, \"k3\": -0.03, \"k4\": 0.004")));
  EXPECT_EQ(kb4.left.distortion, Distortion::equidistant);
  EXPECT_DOUBLE_EQ(kb4.left.coefficients[2], -0.03);
  const auto radtan8 =
      read(write_file(dir + "/r.json", basalt("pinhole-radtan8",
                                              "\"k1\": 0.1, \"k2\": 0.02, \"p1\": 0.001, \"p2\": 0.002, \"k3\": 0.01, "
                                              "\"k4\": 0.2, \"k5\": 0.03, \"k6\": 0.001, \"rpmax\": 2.5")));
  EXPECT_EQ(radtan8.left.distortion, Distortion::rational);
  EXPECT_DOUBLE_EQ(radtan8.left.coefficients[7], 0.001);
}

std::string depthai(int type, const std::string& D, const RigidTransform& T_right_left, bool through_third) {
  const auto pose_text = [](const RigidTransform& T, int to) {
    const auto row = [&](int r) { return fmt::format("[{}, {}, {}]", T.R(r, 0), T.R(r, 1), T.R(r, 2)); };
    return fmt::format(
        "{{\"rotationMatrix\": [{}, {}, {}], \"specTranslation\": {{\"x\": 0, \"y\": 0, \"z\": 0}}, "
        "\"toCameraSocket\": {}, \"translation\": {{\"x\": {}, \"y\": {}, \"z\": {}}}}}",
        row(0), row(1), row(2), to, 100.0 * T.t.x(), 100.0 * T.t.y(), 100.0 * T.t.z());
  };
  const auto camera = [&](int socket, const std::string& extrinsics) {
    return fmt::format(
        "[{}, {{\"cameraType\": {}, \"distortionCoeff\": [{}], \"extrinsics\": {}, \"height\": 800, "
        "\"width\": 1280, \"intrinsicMatrix\": [[800.0, 0.0, 640.0], [0.0, 801.0, 400.0], [0.0, 0.0, "
        "1.0]], \"lensPosition\": 0}}]",
        socket, type, D, extrinsics);
  };
  const RigidTransform third{so3_exp({0.0, 0.01, 0.02}), {-0.0375, 0.001, 0.0}};
  const std::string left = through_third ? pose_text(third, 0) : pose_text(T_right_left, 2);
  const std::string right =
      pose_text(through_third ? third * T_right_left.inverse() : RigidTransform{}, through_third ? 0 : -1);
  return fmt::format(
      "{{\"batchName\": \"\", \"cameraData\": [{}, {}, {}], \"stereoRectificationData\": "
      "{{\"leftCameraSocket\": 1, \"rightCameraSocket\": 2}}}}",
      camera(0, pose_text(RigidTransform{}, -1)), camera(1, left), camera(2, right));
}

TEST(formats, depthai_json_in_centimetres) {
  const std::string dir = test::scratch_dir();
  for (const bool through_third : {false, true}) {
    const auto c = read(write_file(dir + "/calib.json", depthai(0,
                                                                "1.5, 0.2, 0.001, 0.002, 0.3, 1.6, 0.25, 0.31, 0.001, "
                                                                "0, 0, 0, 0.01, 0",
                                                                pose(), through_third)),
                        1280, 800);
    EXPECT_EQ(c.left.distortion, Distortion::thin_prism);
    EXPECT_DOUBLE_EQ(c.left.prism[0], 0.001);
    EXPECT_DOUBLE_EQ(c.left.prism[4], 0.01);
    expect_pose(c);
  }
  const std::string path = write_file(
      dir + "/calib.json", depthai(1, "0.1, 0.02, 0.001, 0.002, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0", pose(), false));
  EXPECT_EQ(read(path, 1280, 800).right.distortion, Distortion::equidistant);
  // 720 rows are the middle of the 800, 640x400 is half of it.
  EXPECT_NEAR(read(path, 1280, 720).left.cy_px, 360.0, 0.6);
  EXPECT_NEAR(read(path, 640, 400).left.fx_px, 400.0, 1e-9);
}

TEST(formats, middlebury_in_millimetres) {
  const std::string path =
      write_file(test::scratch_dir() + "/calib.txt",
                 "cam0=[3997.684 0 1176.728; 0 3997.684 1011.728; 0 0 1]\n"
                 "cam1=[3997.684 0 1307.839; 0 3997.684 1011.728; 0 0 1]\ndoffs=131.111\n"
                 "baseline=193.001\nwidth=2964\nheight=1988\nndisp=280\nisint=0\nvmin=31\nvmax=257\n");
  const auto c = read(path, 2964, 1988);
  EXPECT_TRUE(c.rectified);
  EXPECT_NEAR(c.prescribed->model.baseline_m, 0.193001, 1e-9);
  EXPECT_NEAR(c.prescribed->model.doffs_px, 131.111, 1e-6);
  const auto half = read(path, 1482, 994);
  EXPECT_NEAR(half.prescribed->model.fx_px, 0.5 * 3997.684, 1e-6);
  EXPECT_NEAR(half.prescribed->model.doffs_px, 0.5 * 131.111, 1e-6);
  EXPECT_EQ(half.notes.size(), 1U);
}

std::string kitti_like(const char* left, const char* right, double f, double cx, double cy, double P3,
                       double baseline_m, int width, int height) {
  const auto camera = [&](const char* n, double shift, double t) {
    return fmt::format(
        "S_{0}: {1} {2}\nK_{0}: {3} 0 {4} 0 {3} {5} 0 0 1\nD_{0}: -0.3 0.1 0 0 0\nR_{0}: 1 0 0 0 1 0 0 0 1\n"
        "T_{0}: {6} 0 0\nS_rect_{0}: {7} {8}\nR_rect_{0}: 1 0 0 0 1 0 0 0 1\n"
        "P_rect_{0}: {3} 0 {4} {9} 0 {3} {5} 0 0 0 1 0\n",
        n, width + 20, height + 20, f, cx, cy, t, width, height, shift);
  };
  return "calib_time: 01-Jan-2018 12:00:00\ncorner_dist: 9.95e-02\n" + camera(right, P3, -baseline_m) +
         camera(left, 0.0, 0.0);
}

TEST(formats, kitti_360_and_driving_stereo) {
  const std::string dir = test::scratch_dir();
  const auto kitti = read(write_file(dir + "/perspective.txt",
                                     kitti_like("00", "01", 552.55, 682.05, 238.77, -328.3, 328.3 / 552.55, 1408, 376)),
                          1408, 376);
  EXPECT_TRUE(kitti.rectified);
  EXPECT_NEAR(kitti.prescribed->model.baseline_m, 328.3 / 552.55, 1e-9);
  EXPECT_EQ(find_calibration(dir), dir + "/perspective.txt");
  // The left camera has the higher number, and the halved file the whole image's P[3].
  const auto driving = read(write_file(dir + "/half/2018-07-09.txt", kitti_like("103", "101", 1003.5, 440.0, 200.0,
                                                                                -2.0 * 1003.5 * 0.54, 0.54, 881, 400)),
                            881, 400);
  EXPECT_TRUE(driving.rectified);
  EXPECT_NEAR(driving.prescribed->model.baseline_m, 0.54, 1e-6);
  ASSERT_EQ(driving.notes.size(), 1U);
}

TEST(formats, four_seasons_in_three_files) {
  const std::string dir = test::scratch_dir();
  const std::string camera = "Pinhole 501.475 501.475 421.795 167.658 0.0 0.0 0.0 0.0\n800 400\ncrop\n800 400\n";
  write_file(dir + "/undistorted_calib_0.txt", camera);
  write_file(dir + "/undistorted_calib_1.txt", camera);
  write_file(dir + "/undistorted_calib_stereo.txt", "1 0 0 0.3005\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  for (const char* name : {"/undistorted_calib_stereo.txt", "/undistorted_calib_0.txt", ""}) {
    const auto c = read(dir + name, 800, 400);
    EXPECT_TRUE(c.rectified);
    EXPECT_NEAR(c.prescribed->model.baseline_m, 0.3005, 1e-9);
  }
  std::filesystem::remove(dir + "/undistorted_calib_1.txt");
  EXPECT_FALSE(read_calibration(dir + "/undistorted_calib_0.txt", 800, 400).ok());
}

TEST(formats, zed_sections_by_the_size_of_the_images) {
  std::string text;
  for (const auto& [name, f, cx, cy] :
       {std::tuple{"2K", 1400.0, 1104.0, 621.0}, {"HD", 700.0, 640.0, 360.0}, {"VGA", 350.0, 336.0, 188.0}}) {
    for (const char* side : {"LEFT", "RIGHT"}) {
      text += fmt::format("[{}_CAM_{}]\nfx={}\nfy={}\ncx={}\ncy={}\nk1=-0.17\nk2=0.027\np1=0.0001\np2=0.0002\nk3=0\n\n",
                          side, name, f, f, cx, cy);
    }
  }
  text +=
      "[STEREO]\nBaseline=119.9\nTY=0.02\nTZ=-0.3\nCV_HD=0.001\nRX_HD=0.002\nRZ_HD=-0.003\nCV_VGA=0.004\nRX_VGA=0\n";
  const std::string path = write_file(test::scratch_dir() + "/SN1234.conf", text);
  EXPECT_DOUBLE_EQ(read(path, 1280, 720).left.fx_px, 700.0);
  EXPECT_DOUBLE_EQ(read(path, 672, 376).left.fx_px, 350.0);
  EXPECT_NEAR(read(path, 640, 360).left.fx_px, 350.0, 1e-9);  // half of HD
  EXPECT_NEAR(read(path, 1280, 720).T_right_left.t.x(), -0.1199, 1e-9);
  EXPECT_NEAR(so3_log(read(path, 672, 376).T_right_left.R).y(), 0.004, 1e-9);
  const auto other = read_calibration(path, 640, 480);
  ASSERT_FALSE(other.ok());
  test::expect_clear(other.error(), {"another image size", "640x480"});
}

TEST(formats, a_folder_is_searched_by_what_is_in_its_files) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/times.txt", "0.0\n0.1\n0.2\n");
  write_file(dir + "/groundtruth.txt",
             "1.0 0 0 0 0 0 0 1\n2.0 0 0 0 0 0 0 1\n3.0 0 0 0 0 0 0 1\n4 0 0 0 0 0 0 1\n"
             "5 0 0 0 0 0 0 1\n6 0 0 0 0 0 0 1\n7 0 0 0 0 0 0 1\n8 0 0 0 0 0 0 1\n9 0 0 0 0 0 0 1\n");
  EXPECT_EQ(find_calibration(dir), "");
  write_file(dir + "/my_rig.yml", test::opencv_yaml(rig, true));
  EXPECT_EQ(find_calibration(dir), dir + "/my_rig.yml");
  write_file(dir + "/your_rig.yml", test::opencv_yaml(rig, false));
  const auto several = read_calibration(dir, 640, 480);
  ASSERT_FALSE(several.ok());
  test::expect_clear(several.error(), {"several calibrations"});
}

}  // namespace
}  // namespace cliquevo::drivers
