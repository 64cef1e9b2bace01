// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/writers.h"

#include <array>
#include <filesystem>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "stereo/rectification.h"

namespace cliquevo::drivers {

namespace {

using Files = std::vector<CalibrationFile>;

std::string number(double value) { return fmt::format("{:.17g}", value + 0.0); }

template <typename Numbers>
std::string list(const Numbers& numbers) {
  std::string out;
  for (const double value : numbers) out += fmt::format("{}{}", out.empty() ? "" : ", ", number(value));
  return out;
}

// Row by row.
template <typename Matrix>
std::vector<double> rows_of(const Matrix& m) {
  std::vector<double> out;
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    for (Eigen::Index c = 0; c < m.cols(); ++c) out.push_back(m(r, c));
  }
  return out;
}

Eigen::Matrix3d matrix_of(const CameraCalibration& c) {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = c.fx_px;
  K(1, 1) = c.fy_px;
  K(0, 2) = c.cx_px;
  K(1, 2) = c.cy_px;
  return K;
}

// The coefficients that the model has; a plumb-bob without k3 has four where a format allows them.
std::vector<double> terms_of(const CameraCalibration& c) {
  std::size_t n = 0;
  switch (c.distortion) {
    case Distortion::none:
      break;
    case Distortion::plumb_bob:
      n = 5;
      break;
    case Distortion::rational:
      n = 8;
      break;
    default:
      n = 4;
  }
  return {c.coefficients.begin(), c.coefficients.begin() + static_cast<std::ptrdiff_t>(n)};
}

bool is_supported(const CameraCalibration& c) {
  return c.distortion == Distortion::none || c.distortion == Distortion::plumb_bob ||
         c.distortion == Distortion::rational || c.distortion == Distortion::equidistant;
}

const char* ros_name(Distortion distortion) {
  switch (distortion) {
    case Distortion::rational:
      return "rational_polynomial";
    case Distortion::equidistant:
      return "equidistant";
    default:
      return "plumb_bob";
  }
}

Error unsupported(const char* format, const std::string& path) {
  return {fmt::format("the {} format cannot hold this lens model", format), path,
          "choose another --format, or another --model"};
}

Result<Files> write_opencv(const StereoCalibration& c, const std::string& path) {
  if (!is_supported(c.left) || !is_supported(c.right)) return unsupported("opencv", path);
  const auto matrix = [](const char* name, int rows, int columns, const std::vector<double>& numbers) {
    return fmt::format("{}: !!opencv-matrix\n  rows: {}\n  cols: {}\n  dt: d\n  data: [ {} ]\n", name, rows, columns,
                       list(numbers));
  };
  std::string out = "%YAML:1.0\n---\n";
  out += fmt::format("image_width: {}\nimage_height: {}\n", c.left.width, c.left.height);
  out += fmt::format("distortion_model: {}\n",
                     c.left.distortion == Distortion::none ? "none" : ros_name(c.left.distortion));
  int side = 1;
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    std::vector<double> terms = terms_of(*camera);
    if (terms.empty()) terms.assign(5, 0.0);
    out += matrix(side == 1 ? "K1" : "K2", 3, 3, rows_of(matrix_of(*camera)));
    out += matrix(side == 1 ? "D1" : "D2", 1, static_cast<int>(terms.size()), terms);
    ++side;
  }
  out += matrix("R", 3, 3, rows_of(c.T_right_left.R));
  out += matrix("T", 3, 1, rows_of(c.T_right_left.t));
  return Files{{path, out}};
}

Result<Files> write_kalibr(const StereoCalibration& c, const std::string& path) {
  std::string out;
  int index = 0;
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    std::vector<double> terms = terms_of(*camera);
    const bool has_k3 = camera->distortion == Distortion::plumb_bob && terms[4] != 0.0;
    if (!is_supported(*camera) || camera->distortion == Distortion::rational || has_k3) {
      return unsupported("kalibr", path);
    }
    if (terms.size() > 4) terms.erase(terms.begin() + 4, terms.end());
    const char* model = camera->distortion == Distortion::equidistant ? "equidistant"
                        : camera->distortion == Distortion::none      ? "none"
                                                                      : "radtan";
    out += fmt::format("cam{}:\n", index);
    if (index == 1) {
      out += "  T_cn_cnm1:\n";
      for (int r = 0; r < 3; ++r) {
        const Eigen::Matrix3d& R = c.T_right_left.R;
        out += fmt::format("  - [{}]\n", list(std::array{R(r, 0), R(r, 1), R(r, 2), c.T_right_left.t(r)}));
      }
      out += "  - [0.0, 0.0, 0.0, 1.0]\n";
    }
    out += fmt::format("  camera_model: pinhole\n  intrinsics: [{}]\n",
                       list(std::array{camera->fx_px, camera->fy_px, camera->cx_px, camera->cy_px}));
    out += fmt::format("  distortion_model: {}\n  distortion_coeffs: [{}]\n", model, list(terms));
    out += fmt::format("  resolution: [{}, {}]\n  rostopic: /cam{}/image_raw\n", camera->width, camera->height, index);
    ++index;
  }
  return Files{{path, out}};
}

// left.yaml and right.yaml beside the path's stem.
Result<Files> write_ros(const StereoCalibration& c, const std::string& path) {
  if (!is_supported(c.left) || !is_supported(c.right)) return unsupported("ros", path);
  const auto rectification = stereo::choose_rectification(c);
  if (!rectification) return rectification.error();
  const StereoModel& m = rectification->model;
  const auto matrix = [](const char* name, int rows, int columns, const std::vector<double>& numbers) {
    return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", name, rows, columns, list(numbers));
  };
  const std::filesystem::path whole(path);
  const std::string stem = (whole.parent_path() / whole.stem()).string();
  Files out;
  for (const bool right : {false, true}) {
    const CameraCalibration& camera = right ? c.right : c.left;
    Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
    P(0, 0) = m.fx_px;
    P(1, 1) = m.fy_px;
    P(0, 2) = m.cx_px + (right ? m.doffs_px : 0.0);
    P(1, 2) = m.cy_px;
    P(2, 2) = 1.0;
    if (right) P(0, 3) = -m.fx_px * m.baseline_m;
    std::vector<double> terms = terms_of(camera);
    if (terms.empty()) terms.assign(5, 0.0);
    std::string text = fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.width, camera.height,
                                   right ? "right" : "left");
    text += matrix("camera_matrix", 3, 3, rows_of(matrix_of(camera)));
    text += fmt::format("distortion_model: {}\n", ros_name(camera.distortion));
    text += matrix("distortion_coefficients", 1, static_cast<int>(terms.size()), terms);
    text += matrix("rectification_matrix", 3, 3, rows_of(right ? rectification->R_right : rectification->R_left));
    text += matrix("projection_matrix", 3, 4, rows_of(P));
    out.push_back({stem + (right ? "_right.yaml" : "_left.yaml"), text});
  }
  return out;
}

// Of the rectified pair: for images that are rectified already.
Result<Files> write_kitti(const StereoCalibration& c, const std::string& path) {
  const auto rectification = stereo::choose_rectification(c);
  if (!rectification) return rectification.error();
  const StereoModel& m = rectification->model;
  std::string out;
  for (const bool right : {false, true}) {
    const std::array<double, 12> P{m.fx_px,
                                   0.0,
                                   m.cx_px + (right ? m.doffs_px : 0.0),
                                   right ? -m.fx_px * m.baseline_m : 0.0,
                                   0.0,
                                   m.fy_px,
                                   m.cy_px,
                                   0.0,
                                   0.0,
                                   0.0,
                                   1.0,
                                   0.0};
    out += right ? "P1:" : "P0:";
    for (const double value : P) out += fmt::format(" {}", number(value));
    out += "\n";
  }
  return Files{{path, out}};
}

Result<Files> write_basalt(const StereoCalibration& c, const std::string& path) {
  std::string poses, intrinsics, sizes;
  const RigidTransform poses_of[2] = {{}, c.T_right_left.inverse()};
  int index = 0;
  for (const CameraCalibration* camera : {&c.left, &c.right}) {
    const RigidTransform& T = poses_of[index++];
    const Eigen::Quaterniond q(T.R);
    const std::string comma = poses.empty() ? "" : ",\n";
    poses += fmt::format(R"({}      {{"px": {}, "py": {}, "pz": {}, "qx": {}, "qy": {}, "qz": {}, "qw": {}}})", comma,
                         number(T.t.x()), number(T.t.y()), number(T.t.z()), number(q.x()), number(q.y()), number(q.z()),
                         number(q.w()));
    const char* type = nullptr;
    std::vector<const char*> names;
    switch (camera->distortion) {
      case Distortion::none:
        type = "pinhole";
        break;
      case Distortion::plumb_bob:
        type = "pinhole-radtan5";
        names = {"k1", "k2", "p1", "p2", "k3"};
        break;
      case Distortion::rational:
        type = "pinhole-radtan8";
        names = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
        break;
      case Distortion::equidistant:
        type = "kb4";
        names = {"k1", "k2", "k3", "k4"};
        break;
      default:
        return unsupported("basalt", path);
    }
    std::string terms;
    for (std::size_t i = 0; i < names.size(); ++i) {
      terms += fmt::format(R"(, "{}": {})", names[i], number(camera->coefficients[i]));
    }
    intrinsics += fmt::format(
        R"({}      {{"camera_type": "{}", "intrinsics": {{"fx": {}, "fy": {}, "cx": {}, "cy": {}{}}}}})", comma, type,
        number(camera->fx_px), number(camera->fy_px), number(camera->cx_px), number(camera->cy_px), terms);
    sizes += fmt::format("{}[{}, {}]", sizes.empty() ? "" : ", ", camera->width, camera->height);
  }
  return Files{
      {path, fmt::format("{{\n  \"value0\": {{\n    \"T_imu_cam\": [\n{}\n    ],\n    \"intrinsics\": [\n{}\n    ],\n"
                         "    \"resolution\": [{}]\n  }}\n}}\n",
                         poses, intrinsics, sizes)}};
}

constexpr std::array<CalibrationWriter, 5> kWriters{{
    {"opencv", "OpenCV YAML: K1 D1 K2 D2 R T", write_opencv},
    {"ros", "camera_info of both cameras: FILE_left.yaml, FILE_right.yaml", write_ros},
    {"kalibr", "Kalibr camera chain", write_kalibr},
    {"basalt", "Basalt calibration.json", write_basalt},
    {"kitti", "KITTI calib.txt of the rectified pair, for images that are rectified already", write_kitti},
}};

}  // namespace

std::span<const CalibrationWriter> calibration_writers() { return kWriters; }

const CalibrationWriter* find_calibration_writer(const std::string& name) {
  for (const CalibrationWriter& writer : kWriters) {
    if (name == writer.name) return &writer;
  }
  return nullptr;
}

}  // namespace cliquevo::drivers
