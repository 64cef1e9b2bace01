// SPDX-License-Identifier: BSD-3-Clause
// Every calibration format gives the same rig.
#include <filesystem>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "drivers/calibration_file.h"
#include "tests/support/test_data.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::write_file;

StereoCalibration read(const std::string& path, int width = 0, int height = 0) {
  const auto c = read_calibration(path, width, height);
  EXPECT_TRUE(c.ok()) << c.error().line();
  return c.ok() ? *c : StereoCalibration{};
}

void expect_camera(const CameraCalibration& camera, const test::Rig& rig, bool left, std::size_t coefficients) {
  const Eigen::Matrix3d& K = left ? rig.K_left : rig.K_right;
  EXPECT_EQ(camera.width, rig.width);
  EXPECT_EQ(camera.height, rig.height);
  EXPECT_DOUBLE_EQ(camera.fx_px, K(0, 0));
  EXPECT_DOUBLE_EQ(camera.fy_px, K(1, 1));
  EXPECT_DOUBLE_EQ(camera.cx_px, K(0, 2));
  EXPECT_DOUBLE_EQ(camera.cy_px, K(1, 2));
  for (std::size_t i = 0; i < camera.coefficients.size(); ++i) {
    const double expected = i < coefficients ? (left ? rig.D_left : rig.D_right)[i] : 0.0;
    EXPECT_DOUBLE_EQ(camera.coefficients[i], expected) << i;
  }
}

void expect_rig(const StereoCalibration& c, const test::Rig& rig, std::size_t coefficients) {
  expect_camera(c.left, rig, true, coefficients);
  expect_camera(c.right, rig, false, coefficients);
  EXPECT_LT((c.T_right_left.R - rig.T_right_left.R).norm(), 1e-9);
  EXPECT_LT((c.T_right_left.t - rig.T_right_left.t).norm(), 1e-9);
  EXPECT_FALSE(c.rectified);
}

void expect_prescribed(const StereoCalibration& c, const test::Rig& rig) {
  ASSERT_TRUE(c.prescribed);
  EXPECT_LT((c.prescribed->R_left - rig.R1).norm(), 1e-9);
  EXPECT_LT((c.prescribed->R_right - rig.R2).norm(), 1e-9);
  EXPECT_NEAR(c.prescribed->model.fx_px, rig.P1(0, 0), 1e-9);
  EXPECT_NEAR(c.prescribed->model.cx_px, rig.P1(0, 2), 1e-9);
  EXPECT_NEAR(c.prescribed->model.cy_px, rig.P1(1, 2), 1e-9);
  EXPECT_NEAR(c.prescribed->model.baseline_m, rig.T_right_left.t.norm(), 1e-9);
  EXPECT_EQ(c.prescribed->model.doffs_px, 0.0);
}

TEST(calibration, kitti_odometry_is_a_rectified_pair_of_the_images_size) {
  const std::string path = write_file(test::scratch_dir() + "/calib.txt", test::kitti_calibration());
  const StereoCalibration c = read(path, 64, 48);
  EXPECT_TRUE(c.rectified);
  ASSERT_TRUE(c.prescribed);
  EXPECT_EQ(c.prescribed->model.width, 64);
  EXPECT_EQ(c.prescribed->model.height, 48);
  EXPECT_DOUBLE_EQ(c.prescribed->model.fx_px, 100.0);
  EXPECT_DOUBLE_EQ(c.prescribed->model.baseline_m, 0.5);
  EXPECT_EQ(c.prescribed->model.doffs_px, 0.0);
  EXPECT_EQ(c.source, path);
  EXPECT_TRUE(read_calibration(path, 0, 0).ok());  // the file has no size
}

TEST(calibration, unequal_principal_points_of_a_rectified_pair_become_doffs) {
  const std::string path =
      write_file(test::scratch_dir() + "/calib.txt", test::kitti_calibration(100.0, 31.5, 36.25, 0.5));
  const StereoCalibration c = read(path, 64, 48);
  EXPECT_TRUE(c.rectified);
  EXPECT_DOUBLE_EQ(c.prescribed->model.doffs_px, 4.75);
  EXPECT_DOUBLE_EQ(c.prescribed->model.cx_px, 31.5);
}

TEST(calibration, unequal_focal_lengths_are_left_to_rectification) {
  const std::string path =
      write_file(test::scratch_dir() + "/calib.txt",
                 "P0: 100 0 31.5 0 0 100 23.5 0 0 0 1 0\nP1: 110 0 31.5 -55 0 110 23.5 0 0 0 1 0\n");
  const StereoCalibration c = read(path, 64, 48);
  EXPECT_FALSE(c.rectified);
  EXPECT_FALSE(c.prescribed);
  EXPECT_DOUBLE_EQ(c.right.fx_px, 110.0);
  EXPECT_DOUBLE_EQ(c.T_right_left.t.x(), -0.5);
}

TEST(calibration, kitti_raw_of_images_as_grabbed) {
  const test::Rig rig = test::make_rig();
  const std::string path = write_file(test::scratch_dir() + "/calib_cam_to_cam.txt", test::kitti_raw_txt(rig));
  const StereoCalibration c = read(path, rig.width, rig.height);
  expect_rig(c, rig, 5);
  expect_prescribed(c, rig);
  EXPECT_EQ(c.left.distortion, Distortion::plumb_bob);
  EXPECT_EQ(c.prescribed->model.width, rig.width - 40);
  EXPECT_EQ(c.prescribed->model.height, rig.height - 60);
}

TEST(calibration, kitti_raw_of_images_that_are_rectified) {
  const test::Rig rig = test::make_rig();
  const std::string path = write_file(test::scratch_dir() + "/calib_cam_to_cam.txt", test::kitti_raw_txt(rig));
  const StereoCalibration c = read(path, rig.width - 40, rig.height - 60);
  EXPECT_TRUE(c.rectified);
  EXPECT_NEAR(c.prescribed->model.fx_px, rig.P1(0, 0), 1e-9);
  EXPECT_EQ(c.prescribed->model.width, rig.width - 40);
}

TEST(calibration, euroc_pair_of_sensor_files) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/mav0/cam0/sensor.yaml", test::euroc_yaml(rig, true));
  write_file(dir + "/mav0/cam1/sensor.yaml", test::euroc_yaml(rig, false));
  for (const char* name : {"/mav0/cam0/sensor.yaml", "/mav0/cam1/sensor.yaml", "/mav0", ""}) {
    const StereoCalibration c = read(dir + name, rig.width, rig.height);
    expect_rig(c, rig, 4);
    EXPECT_FALSE(c.prescribed);
    EXPECT_EQ(c.left.distortion, Distortion::plumb_bob);
  }
}

TEST(calibration, kalibr_chain_in_each_distortion_model) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const StereoCalibration radtan = read(write_file(dir + "/camchain.yaml", test::kalibr_yaml(rig)), 640, 480);
  expect_rig(radtan, rig, 4);
  EXPECT_EQ(radtan.left.distortion, Distortion::plumb_bob);
  const StereoCalibration fisheye = read(write_file(dir + "/a/camchain.yaml", test::kalibr_yaml(rig, "equidistant")));
  expect_rig(fisheye, rig, 4);
  EXPECT_EQ(fisheye.left.distortion, Distortion::equidistant);
  const StereoCalibration none = read(write_file(dir + "/b/run1-camchain.yaml", test::kalibr_yaml(rig, "none")));
  expect_rig(none, rig, 0);
  EXPECT_EQ(none.left.distortion, Distortion::none);
  expect_rig(read(dir + "/b"), rig, 0);  // found in the folder by its name
}

TEST(calibration, ros_camera_info_pair) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/left.yaml", test::ros_yaml(rig, true));
  write_file(dir + "/right.yaml", test::ros_yaml(rig, false));
  for (const char* name : {"/left.yaml", "/right.yaml", ""}) {
    const StereoCalibration c = read(dir + name, rig.width, rig.height);
    expect_rig(c, rig, 5);
    expect_prescribed(c, rig);
    EXPECT_EQ(c.prescribed->model.width, rig.width);
  }
}

TEST(calibration, ros_message_as_printed_with_rational_and_fisheye_models) {
  const test::Rig rig = test::make_rig();
  for (const bool fisheye : {false, true}) {
    const std::string dir = test::scratch_dir();
    for (const bool left : {true, false}) {
      const auto list = [](const Eigen::MatrixXd& m) { return test::list_of(m); };
      write_file(
          dir + (left ? "/left.yaml" : "/right.yaml"),
          fmt::format("header:\n  seq: 0\nheight: {}\nwidth: {}\ndistortion_model: {}\nD: [{}]\nK: [{}]\nR: [{}]\n"
                      "P: [{}]\nbinning_x: 0\n---\n",
                      rig.height, rig.width, fisheye ? "equidistant" : "rational_polynomial",
                      fisheye ? "0.1, 0.02, 0.003, 0.0004" : "1, 2, 0.003, 0.004, 5, 6, 7, 8",
                      list(left ? rig.K_left : rig.K_right), list(left ? rig.R1 : rig.R2),
                      list(left ? rig.P1 : rig.P2)));
    }
    const StereoCalibration c = read(dir + "/left.yaml", rig.width, rig.height);
    EXPECT_EQ(c.right.distortion, fisheye ? Distortion::equidistant : Distortion::rational);
    EXPECT_DOUBLE_EQ(c.right.coefficients[7], fisheye ? 0.0 : 8.0);
    EXPECT_DOUBLE_EQ(c.right.coefficients[3], fisheye ? 0.0004 : 0.004);
    expect_prescribed(c, rig);
  }
}

TEST(calibration, ros_baseline_from_T_where_the_projection_has_none) {
  test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  write_file(dir + "/left.yaml", test::ros_yaml(rig, true));
  rig.P2(0, 3) = 0.0;
  write_file(dir + "/right.yaml",
             test::ros_yaml(rig, false) + "T: [" + test::list_of(Eigen::MatrixXd(rig.T_right_left.t)) + "]\n");
  expect_rig(read(dir + "/left.yaml"), rig, 5);
}

TEST(calibration, opencv_stereo_file_with_and_without_rectification) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const StereoCalibration plain = read(write_file(dir + "/stereo.yml", test::opencv_yaml(rig, false)), 640, 480);
  expect_rig(plain, rig, 5);
  EXPECT_FALSE(plain.prescribed);
  const StereoCalibration rectified = read(write_file(dir + "/b/stereo.yml", test::opencv_yaml(rig, true)), 640, 480);
  expect_rig(rectified, rig, 5);
  expect_prescribed(rectified, rig);
}

TEST(calibration, opencv_files_as_file_storage_writes_them) {
  const test::Rig rig = test::make_rig();
  const std::string dir = test::scratch_dir();
  const auto to_cv = [](const Eigen::MatrixXd& m) {
    cv::Mat out(static_cast<int>(m.rows()), static_cast<int>(m.cols()), CV_64F);
    for (int r = 0; r < out.rows; ++r) {
      for (int c = 0; c < out.cols; ++c) out.at<double>(r, c) = m(r, c);
    }
    return out;
  };
  {
    cv::FileStorage in(dir + "/intrinsics.yml", cv::FileStorage::WRITE);
    in << "M1" << to_cv(rig.K_left) << "D1" << cv::Mat(rig.D_left).t() << "M2" << to_cv(rig.K_right) << "D2"
       << cv::Mat(rig.D_right).t();
    cv::FileStorage ex(dir + "/extrinsics.yml", cv::FileStorage::WRITE);
    ex << "R" << to_cv(rig.T_right_left.R) << "T" << to_cv(rig.T_right_left.t) << "R1" << to_cv(rig.R1) << "R2"
       << to_cv(rig.R2) << "P1" << to_cv(rig.P1) << "P2" << to_cv(rig.P2);
  }
  for (const char* name : {"/intrinsics.yml", "/extrinsics.yml", ""}) {
    const StereoCalibration c = read(dir + name, rig.width, rig.height);
    expect_rig(c, rig, 5);
    expect_prescribed(c, rig);
  }
}

TEST(calibration, dso_stereo_file_absolute_and_relative) {
  const std::string dir = test::scratch_dir();
  const StereoCalibration c =
      read(write_file(dir + "/a.txt", "Pinhole 261.4 262.5 334.9 188.9 0\n672 376\ncrop\n672 376\n0.12\n"), 672, 376);
  EXPECT_TRUE(c.rectified);
  ASSERT_TRUE(c.prescribed);
  EXPECT_DOUBLE_EQ(c.prescribed->model.fx_px, 261.4);
  EXPECT_DOUBLE_EQ(c.prescribed->model.fy_px, 262.5);
  EXPECT_DOUBLE_EQ(c.prescribed->model.cx_px, 334.9);
  EXPECT_DOUBLE_EQ(c.prescribed->model.baseline_m, 0.12);
  for (const char* mode : {"full", "none"}) {
    EXPECT_TRUE(
        read(write_file(dir + "/c.txt", fmt::format("261.4 262.5 334.9 188.9 0\n672 376\n{}\n672 376\n0.12\n", mode)))
            .rectified);
  }
  const StereoCalibration relative =
      read(write_file(dir + "/b.txt", "Pinhole 0.5 0.6 0.5 0.5 0\n640 480\ncrop\n640 480\n0.1\n"), 640, 480);
  EXPECT_DOUBLE_EQ(relative.prescribed->model.fx_px, 320.0);
  EXPECT_DOUBLE_EQ(relative.prescribed->model.fy_px, 288.0);
  EXPECT_DOUBLE_EQ(relative.prescribed->model.cx_px, 319.5);
  EXPECT_DOUBLE_EQ(relative.prescribed->model.cy_px, 239.5);
}

TEST(calibration, dso_distorted_cameras_and_output_camera) {
  const std::string dir = test::scratch_dir();
  const StereoCalibration radtan =
      read(write_file(dir + "/a.txt", "RadTan 300 300 320 240 -0.3 0.1 0.001 0.002\n640 480\ncrop\n640 480\n0.12\n"),
           640, 480);
  EXPECT_FALSE(radtan.rectified);
  EXPECT_EQ(radtan.left.distortion, Distortion::plumb_bob);
  EXPECT_DOUBLE_EQ(radtan.right.coefficients[3], 0.002);
  const StereoCalibration out = read(
      write_file(dir + "/b.txt", "EquiDistant 300 300 320 240 0.1 0 0 0\n640 480\n250 250 160 120 0\n320 240\n0.12\n"));
  EXPECT_EQ(out.left.distortion, Distortion::equidistant);
  ASSERT_TRUE(out.prescribed);
  EXPECT_EQ(out.prescribed->model.width, 320);
  EXPECT_DOUBLE_EQ(out.prescribed->model.fx_px, 250.0);
}

TEST(calibration, undistorted_parallel_cameras_need_no_warp_in_any_format) {
  test::Rig rig = test::make_rig();
  rig.K_right = rig.K_left;
  rig.T_right_left = {Eigen::Matrix3d::Identity(), {-0.1, 0.0, 0.0}};
  const StereoCalibration c = read(write_file(test::scratch_dir() + "/camchain.yaml", test::kalibr_yaml(rig, "none")));
  EXPECT_TRUE(c.rectified);
  ASSERT_TRUE(c.prescribed);
  EXPECT_DOUBLE_EQ(c.prescribed->model.fx_px, rig.K_left(0, 0));
  EXPECT_DOUBLE_EQ(c.prescribed->model.baseline_m, 0.1);
  // Not so for a fisheye: its rays bend even with coefficients of zero.
  rig.D_left = rig.D_right = {0, 0, 0, 0, 0};
  EXPECT_FALSE(
      read(write_file(test::scratch_dir() + "/camchain.yaml", test::kalibr_yaml(rig, "equidistant"))).rectified);
}

}  // namespace
}  // namespace cliquevo::drivers
