// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/recording/fixtures.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgcodecs.hpp>

namespace cliquevo::test {

namespace fs = std::filesystem;

std::string write_file(const std::string& path, const std::string& content) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

int pixel_of(int x, int y, int seed) { return (x * 7 + y * 13 + seed * 29 + (x * y) % 11) & 255; }

void write_image(const std::string& path, int width, int height, int seed) {
  fs::create_directories(fs::path(path).parent_path());
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(pixel_of(x, y, seed));
  }
  ASSERT_TRUE(cv::imwrite(path, image));
}

void write_colour_image(const std::string& path, int width, int height, int blue, int green, int red) {
  fs::create_directories(fs::path(path).parent_path());
  ASSERT_TRUE(cv::imwrite(path, cv::Mat(height, width, CV_8UC3, cv::Scalar(blue, green, red))));
}

void truncate_file(const std::string& path, double part) {
  fs::resize_file(path, static_cast<std::uintmax_t>(static_cast<double>(fs::file_size(path)) * part));
}

std::string kitti_calibration(double focal_px, double cx_left_px, double cx_right_px, double baseline_m) {
  return fmt::format("P0: {0} 0 {1} 0 0 {0} 23.5 0 0 0 1 0\nP1: {0} 0 {2} {3} 0 {0} 23.5 0 0 0 1 0\n", focal_px,
                     cx_left_px, cx_right_px, -focal_px * baseline_m);
}

std::string write_kitti_odometry(const std::string& folder, int count) {
  std::string times;
  for (int i = 0; i < count; ++i) {
    write_image(fmt::format("{}/image_0/{:06}.png", folder, i), 64, 48, 2 * i);
    write_image(fmt::format("{}/image_1/{:06}.png", folder, i), 64, 48, 2 * i + 1);
    times += fmt::format("{:e}\n", 0.1 * i);
  }
  write_file(folder + "/times.txt", times);
  write_file(folder + "/calib.txt", kitti_calibration());
  return folder;
}

Rig make_rig() {
  Rig rig;
  rig.K_left << 458.654, 0, 320.215, 0, 457.296, 241.375, 0, 0, 1;
  rig.K_right << 455.587, 0, 324.999, 0, 456.134, 238.5, 0, 0, 1;
  rig.D_left = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0.01};
  rig.D_right = {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05, -0.005};
  rig.T_right_left.R = so3_exp({0.01, -0.02, 0.015});
  rig.T_right_left.t = {-0.11, 0.002, -0.003};
  cv::Mat K1;
  cv::Mat K2;
  cv::Mat R;
  cv::Mat T;
  cv::eigen2cv(rig.K_left, K1);
  cv::eigen2cv(rig.K_right, K2);
  cv::eigen2cv(rig.T_right_left.R, R);
  cv::eigen2cv(rig.T_right_left.t, T);
  cv::Mat R1;
  cv::Mat R2;
  cv::Mat P1;
  cv::Mat P2;
  cv::Mat Q;
  cv::stereoRectify(K1, rig.D_left, K2, rig.D_right, {rig.width, rig.height}, R, T, R1, R2, P1, P2, Q);
  cv::cv2eigen(R1, rig.R1);
  cv::cv2eigen(R2, rig.R2);
  cv::cv2eigen(P1, rig.P1);
  cv::cv2eigen(P2, rig.P2);
  return rig;
}

std::string list_of(const std::vector<double>& v) {
  std::string out;
  for (const double x : v) out += fmt::format("{}{}", out.empty() ? "" : ", ", x);
  return out;
}

std::string list_of(const Eigen::MatrixXd& m) {
  std::vector<double> v;
  for (int r = 0; r < m.rows(); ++r) {
    for (int c = 0; c < m.cols(); ++c) v.push_back(m(r, c));
  }
  return list_of(v);
}

namespace {

std::string rows_of(const RigidTransform& T) {
  std::string out;
  for (int r = 0; r < 3; ++r) {
    out += fmt::format("  - [{}, {}, {}, {}]\n", T.R(r, 0), T.R(r, 1), T.R(r, 2), T.t(r));
  }
  return out + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

std::string spaced(std::string list) {
  for (char& c : list) c = c == ',' ? ' ' : c;
  return list;
}

std::string intrinsics_of(const Eigen::Matrix3d& K) {
  return list_of(std::vector<double>{K(0, 0), K(1, 1), K(0, 2), K(1, 2)});
}

std::vector<double> four(const std::vector<double>& v) { return {v.begin(), v.begin() + 4}; }

std::string opencv_matrix(const std::string& name, const Eigen::MatrixXd& m) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", name, m.rows(),
                     m.cols(), list_of(m));
}

}  // namespace

std::string euroc_yaml(const Rig& rig, bool left) {
  // The body frame is turned against the cameras, as on a real vehicle.
  const RigidTransform T_body_left{so3_exp({0.1, -1.2, 1.1}), {0.3, -0.1, 0.05}};
  const RigidTransform T = left ? T_body_left : T_body_left * rig.T_right_left.inverse();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = T.R;
  m.topRightCorner<3, 1>() = T.t;
  return fmt::format(
      "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor\n\nT_BS:\n  cols: 4\n  rows: 4\n  data: "
      "[{}]\n\nrate_hz: 20\nresolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: [{}] #fu, fv, cu, cv\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [{}]\n",
      list_of(m), rig.width, rig.height, intrinsics_of(left ? rig.K_left : rig.K_right),
      list_of(four(left ? rig.D_left : rig.D_right)));
}

std::string kalibr_yaml(const Rig& rig, const std::string& model) {
  std::string out;
  for (const bool left : {true, false}) {
    out += left ? "cam0:\n" : "cam1:\n";
    if (!left) out += "  T_cn_cnm1:\n" + rows_of(rig.T_right_left);
    out += fmt::format(
        "  cam_overlaps: [{}]\n  camera_model: pinhole\n  distortion_coeffs: [{}]\n  distortion_model: {}\n"
        "  intrinsics: [{}]\n  resolution: [{}, {}]\n  rostopic: /cam{}/image_raw\n",
        left ? 1 : 0, model == "none" ? "" : list_of(four(left ? rig.D_left : rig.D_right)), model,
        intrinsics_of(left ? rig.K_left : rig.K_right), rig.width, rig.height, left ? 0 : 1);
  }
  return out;
}

std::string ros_yaml(const Rig& rig, bool left) {
  const std::vector<double>& D = left ? rig.D_left : rig.D_right;
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [{}]\n"
      "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [{}]\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
      "  data: [{}]\n",
      rig.width, rig.height, left ? "left" : "right", list_of(Eigen::MatrixXd(left ? rig.K_left : rig.K_right)),
      D.size(), list_of(D), list_of(Eigen::MatrixXd(left ? rig.R1 : rig.R2)),
      list_of(Eigen::MatrixXd(left ? rig.P1 : rig.P2)));
}

std::string opencv_yaml(const Rig& rig, bool rectification) {
  const auto row = [](const std::vector<double>& v) {
    return Eigen::MatrixXd(Eigen::Map<const Eigen::RowVectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
  };
  std::string out = fmt::format("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", rig.width, rig.height);
  out += opencv_matrix("K1", rig.K_left) + opencv_matrix("D1", row(rig.D_left));
  out += opencv_matrix("K2", rig.K_right) + opencv_matrix("D2", row(rig.D_right));
  out += opencv_matrix("R", rig.T_right_left.R) + opencv_matrix("T", rig.T_right_left.t);
  if (rectification) {
    out += opencv_matrix("R1", rig.R1) + opencv_matrix("R2", rig.R2);
    out += opencv_matrix("P1", rig.P1) + opencv_matrix("P2", rig.P2);
  }
  return out;
}

std::string kitti_raw_txt(const Rig& rig) {
  std::string out = "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.950000e-02\n";
  for (const bool left : {true, false}) {
    const std::string s = left ? "00" : "01";
    const RigidTransform T = left ? RigidTransform{} : rig.T_right_left;
    out += fmt::format("S_{}: {} {}\n", s, rig.width, rig.height);
    out += fmt::format("K_{}: {}\n", s, spaced(list_of(Eigen::MatrixXd(left ? rig.K_left : rig.K_right))));
    out += fmt::format("D_{}: {}\n", s, spaced(list_of(left ? rig.D_left : rig.D_right)));
    out += fmt::format("R_{}: {}\n", s, spaced(list_of(Eigen::MatrixXd(T.R))));
    out += fmt::format("T_{}: {}\n", s, spaced(list_of(Eigen::MatrixXd(T.t))));
    out += fmt::format("S_rect_{}: {} {}\n", s, rig.width - 40, rig.height - 60);
    out += fmt::format("R_rect_{}: {}\n", s, spaced(list_of(Eigen::MatrixXd(left ? rig.R1 : rig.R2))));
    out += fmt::format("P_rect_{}: {}\n", s, spaced(list_of(Eigen::MatrixXd(left ? rig.P1 : rig.P2))));
  }
  return out;
}

void expect_clear(const Error& error, const std::vector<std::string>& fragments) {
  const std::string line = error.line();
  EXPECT_FALSE(error.what.empty()) << line;
  EXPECT_FALSE(error.where.empty()) << line;
  EXPECT_FALSE(error.remedy.empty()) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  for (const std::string& fragment : fragments) {
    EXPECT_NE(line.find(fragment), std::string::npos) << "'" << fragment << "' is not in: " << line;
  }
}

void expect_open_error(const drivers::RecordingOptions& options, const std::vector<std::string>& fragments) {
  const auto source = drivers::open_recording(options);
  ASSERT_FALSE(source.ok()) << "opened: " << options.path;
  expect_clear(source.error(), fragments);
}

void expect_open_error(const std::string& path, const std::vector<std::string>& fragments) {
  drivers::RecordingOptions options;
  options.path = path;
  expect_open_error(options, fragments);
}

}  // namespace cliquevo::test
