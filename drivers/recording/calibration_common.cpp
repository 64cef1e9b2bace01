// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/calibration_common.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/recording/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr double kMostBaseline_m = 10.0;  // millimetres taken for metres, in all likelihood
constexpr double kMostCoefficient = 1000.0;
constexpr double kRotationTolerance = 1e-3;  // files print six digits and more

Result<void> check_camera(const CameraCalibration& c, const std::string& where) {
  for (const double v : {c.fx_px, c.fy_px, c.cx_px, c.cy_px}) {
    if (!std::isfinite(v)) return calibration_error("camera matrix is not finite", where);
  }
  if (c.fx_px <= 0.0 || c.fy_px <= 0.0)
    return calibration_error("camera matrix is singular (focal length <= 0)", where);
  if (c.width > 0 && (c.fx_px < 0.05 * c.width || c.fx_px > 100.0 * c.width || c.fy_px < 0.05 * c.width ||
                      c.fy_px > 100.0 * c.width)) {
    return calibration_error(
        fmt::format("focal length {:.6g}, {:.6g} px does not fit {} px of width", c.fx_px, c.fy_px, c.width), where);
  }
  if (c.width > 0 && (std::abs(c.cx_px) > 4.0 * c.width || std::abs(c.cy_px) > 4.0 * c.height)) {
    return calibration_error(fmt::format("principal point {:.6g}, {:.6g} px is far off the image", c.cx_px, c.cy_px),
                             where);
  }
  for (const double k : c.coefficients) {
    if (!std::isfinite(k) || std::abs(k) > kMostCoefficient) {
      return calibration_error("distortion coefficient is absurd", where);
    }
  }
  return {};
}

Result<void> check_translation(const Eigen::Vector3d& t, const std::string& where) {
  if (!t.allFinite()) return calibration_error("translation between the eyes is not finite", where);
  const double length = t.norm();
  if (length < 1e-4) return calibration_error("baseline is zero", where);
  if (length > kMostBaseline_m) {
    return calibration_error(
        fmt::format("baseline of {:.6g} m is absurd (the unit is m; are these millimetres?)", length), where);
  }
  if (t.x() >= 0.0) return calibration_error("right camera lies left of the left one (eyes swapped)", where);
  if (-t.x() < 0.5 * length) return calibration_error("eyes are not side by side", where);
  return {};
}

Result<void> check_model(const StereoModel& model, const std::string& where) {
  StereoModel sized = model;
  if (sized.width <= 0) {  // no size is known yet: a stand-in that the focal length and centre must fit all the same
    sized.width = static_cast<int>(std::clamp(2.0 * model.cx_px, 16.0, 16384.0));
    sized.height = static_cast<int>(std::clamp(2.0 * model.cy_px, 16.0, 16384.0));
  }
  if (const Result<void> ok = sized.check(); !ok) return calibration_error(ok.error().where, where);
  if (model.baseline_m > kMostBaseline_m) {
    return calibration_error(
        fmt::format("baseline of {:.6g} m is absurd (the unit is m; are these millimetres?)", model.baseline_m), where);
  }
  return {};
}

bool is_undistorted(const CameraCalibration& c) {
  // Fisheye without coefficients still bends rays.
  if (c.distortion == Distortion::equidistant) return false;
  return std::all_of(c.coefficients.begin(), c.coefficients.end(), [](double k) { return k == 0.0; });
}

bool near(double a, double b) { return std::abs(a - b) < 1e-6; }

bool is_identity(const Eigen::Matrix3d& R) { return (R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9; }

// Rows are epipolar lines already: no distortion, no rotation, same f and cy.
std::optional<StereoModel> model_without_warp(const StereoCalibration& c) {
  const CameraCalibration& l = c.left;
  const CameraCalibration& r = c.right;
  const Eigen::Vector3d& t = c.T_right_left.t;
  const bool parallel = is_identity(c.T_right_left.R) && std::abs(t.y()) < 1e-9 && std::abs(t.z()) < 1e-9;
  if (!is_undistorted(l) || !is_undistorted(r) || !parallel) return std::nullopt;
  if (!near(l.fx_px, r.fx_px) || !near(l.fy_px, r.fy_px) || !near(l.cy_px, r.cy_px)) return std::nullopt;
  StereoModel m;
  m.width = l.width;
  m.height = l.height;
  m.fx_px = l.fx_px;
  m.fy_px = l.fy_px;
  m.cx_px = l.cx_px;
  m.cy_px = l.cy_px;
  m.baseline_m = -t.x();
  m.doffs_px = near(r.cx_px, l.cx_px) ? 0.0 : r.cx_px - l.cx_px;
  return m;
}

bool same_model(const StereoModel& a, const StereoModel& b) {
  return a.width == b.width && a.height == b.height && near(a.fx_px, b.fx_px) && near(a.fy_px, b.fy_px) &&
         near(a.cx_px, b.cx_px) && near(a.cy_px, b.cy_px) && near(a.doffs_px, b.doffs_px);
}

// The rectified eyes must differ by the baseline alone, to what files round to.
Result<void> check_fit(const PrescribedRectification& p, const RigidTransform& T_right_left, const std::string& where) {
  const Eigen::Matrix3d between = p.R_right * T_right_left.R * p.R_left.transpose();
  const Eigen::Vector3d shift = p.R_right * T_right_left.t + Eigen::Vector3d(p.model.baseline_m, 0.0, 0.0);
  if ((between - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.02 ||
      shift.norm() > 0.03 * p.model.baseline_m) {
    return calibration_error("prescribed rectification does not fit rotation and baseline of the eyes", where);
  }
  return {};
}

// Files without a size (KITTI odometry, some of OpenCV's) betray another one by a principal point far from the middle.
Result<void> check_centre(const CameraCalibration& c, const std::string& where) {
  const double off_x = std::abs(c.cx_px / c.width - 0.5);
  const double off_y = std::abs(c.cy_px / c.height - 0.5);
  if ((off_x < 0.25 || off_y < 0.25) && off_x < 0.4) return {};
  return Error{
      "calibration is of another image size", where,
      fmt::format("its principal point {:.1f}, {:.1f} px suits about {:.0f}x{:.0f}, the images are {}x{}: name "
                  "the calibration of these images",
                  c.cx_px, c.cy_px, 2.0 * c.cx_px, 2.0 * c.cy_px, c.width, c.height)};
}

Result<void> settle_size(CameraCalibration& camera, const CalibrationRequest& request, const std::string& where) {
  if (camera.width == 0 && camera.height == 0) {
    camera.width = request.width;
    camera.height = request.height;
    if (auto ok = check_camera(camera, where); !ok) return ok;
    return request.width > 0 ? check_centre(camera, where) : Result<void>{};
  }
  if (camera.width < 16 || camera.height < 16 || camera.width > 16384 || camera.height > 16384) {
    return calibration_error(fmt::format("image size {}x{} is absurd", camera.width, camera.height), request.path);
  }
  if (request.width > 0 && (camera.width != request.width || camera.height != request.height)) {
    return size_error(request.path, camera.width, camera.height, request.width, request.height);
  }
  return check_camera(camera, where);
}

}  // namespace

Error calibration_error(const std::string& what, const std::string& where) {
  return {what, where, "calibrate the cameras again or name the right calibration file"};
}

Error size_error(const std::string& path, int width, int height, int image_width, int image_height) {
  return {"calibration is of another image size", path,
          fmt::format("it is for {}x{}, the images are {}x{}: name the calibration of these images", width, height,
                      image_width, image_height)};
}

Result<void> check_rotation(const Eigen::Matrix3d& R, const std::string& where) {
  const bool orthonormal =
      R.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance;
  if (!orthonormal || R.determinant() < 0.0)
    return calibration_error("rotation matrix is singular or no rotation", where);
  return {};
}

Result<void> set_distortion(const std::string& name, const std::vector<double>& coefficients, const std::string& where,
                            CameraCalibration& camera) {
  std::string key;
  for (const char c : name) {
    if (c == '_' || c == '-' || c == ' ') continue;
    key += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  const std::size_t n = coefficients.size();
  std::size_t most = 0;
  if (key == "none" || (key.empty() && n == 0)) {
    camera.distortion = Distortion::none;
  } else if (key == "plumbbob" || key == "radtan" || key == "radialtangential" || (key.empty() && n <= 5)) {
    camera.distortion = Distortion::plumb_bob;
    most = 5;
    if (n != 0 && n != 4 && n != 5) {
      return Error{fmt::format("distortion has {} numbers instead of 4 or 5", n), where, "copy the calibration again"};
    }
  } else if (key == "rationalpolynomial" || key == "rational" || key.empty()) {
    camera.distortion = Distortion::rational;
    most = 8;
    if (n != 8 && n != 12 && n != 14) {
      return Error{fmt::format("distortion has {} numbers instead of 8", n), where, "copy the calibration again"};
    }
  } else if (key == "equidistant" || key == "equi" || key == "fisheye" || key == "kannalabrandt") {
    camera.distortion = Distortion::equidistant;
    most = 4;
    if (n != 4) {
      return Error{fmt::format("distortion has {} numbers instead of 4", n), where, "copy the calibration again"};
    }
  } else {
    return Error{"distortion model " + printable(key.substr(0, 32)) + " is not known", where,
                 "use plumb_bob (radtan), rational_polynomial, equidistant or none"};
  }
  // OpenCV's thin prism and tilt follow the eight; only files that leave them at zero are of a model we have.
  for (std::size_t i = most; i < n; ++i) {
    if (coefficients[i] != 0.0)
      return Error{"distortion has terms that are not known", where, "calibrate without them"};
  }
  camera.coefficients.fill(0.0);
  std::copy_n(coefficients.begin(), std::min(n, most), camera.coefficients.begin());
  return {};
}

Result<void> set_camera_matrix(const std::vector<double>& K, const std::string& where, CameraCalibration& camera) {
  if (K[0] <= 0.0 || K[4] <= 0.0 || K[8] == 0.0) {
    return calibration_error("camera matrix is singular (focal length <= 0)", where);
  }
  if (std::abs(K[1]) > 1e-3 * K[0] || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
    return calibration_error("camera matrix is not that of a pinhole camera", where);
  }
  camera.fx_px = K[0];
  camera.fy_px = K[4];
  camera.cx_px = K[2];
  camera.cy_px = K[5];
  return {};
}

Result<StereoModel> model_from_projections(const std::vector<double>& P_left, const std::vector<double>& P_right,
                                           const std::string& where) {
  for (const std::vector<double>* P : {&P_left, &P_right}) {
    const std::vector<double>& p = *P;
    if (p[0] <= 0.0 || p[5] <= 0.0) return calibration_error("projection is singular (focal length <= 0)", where);
    if (std::abs(p[1]) > 1e-6 * p[0] || p[4] != 0.0 || p[8] != 0.0 || p[9] != 0.0 || std::abs(p[10] - 1.0) > 1e-9) {
      return calibration_error("projection is not that of a rectified camera", where);
    }
    if (std::abs(p[7]) > 1e-3 * std::abs(P_right[3])) return calibration_error("eyes are not side by side", where);
  }
  if (!near(P_left[0], P_right[0]) || !near(P_left[5], P_right[5]) || !near(P_left[6], P_right[6])) {
    return calibration_error("projections of the eyes have unequal focal lengths or rows", where);
  }
  StereoModel m;
  m.fx_px = P_left[0];
  m.fy_px = P_left[5];
  m.cx_px = P_left[2];
  m.cy_px = P_left[6];
  m.baseline_m = P_left[3] / P_left[0] - P_right[3] / P_right[0];
  m.doffs_px = near(P_left[2], P_right[2]) ? 0.0 : P_right[2] - P_left[2];
  return m;
}

Eigen::Matrix3d matrix3_from(const std::vector<double>& v) {
  Eigen::Matrix3d m;
  m << v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8];
  return m;
}

Result<StereoCalibration> finish_calibration(StereoCalibration c, const CalibrationRequest& request) {
  c.source = request.path;
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    const char* eye = camera == &c.left ? " (left eye)" : " (right eye)";
    if (const Result<void> ok = settle_size(*camera, request, request.path + eye); !ok) return ok.error();
  }
  if (c.left.width != c.right.width || c.left.height != c.right.height) {
    return calibration_error(fmt::format("eyes have unequal sizes ({}x{} and {}x{})", c.left.width, c.left.height,
                                         c.right.width, c.right.height),
                             request.path);
  }
  if (const Result<void> ok = check_rotation(c.T_right_left.R, request.path + " (left to right)"); !ok) {
    return ok.error();
  }
  if (const Result<void> ok = check_translation(c.T_right_left.t, request.path); !ok) return ok.error();
  c.T_right_left = c.T_right_left.normalized();
  if (c.prescribed) {
    PrescribedRectification& p = *c.prescribed;
    if (p.model.width == 0) {
      p.model.width = c.left.width;
      p.model.height = c.left.height;
    }
    if (const Result<void> ok = check_model(p.model, request.path + " (rectified)"); !ok) return ok.error();
    for (Eigen::Matrix3d* R : {&p.R_left, &p.R_right}) {
      if (const Result<void> ok = check_rotation(*R, request.path + " (rectifying rotation)"); !ok) return ok.error();
      *R = RigidTransform{*R, Eigen::Vector3d::Zero()}.normalized().R;
    }
    if (const Result<void> ok = check_fit(p, c.T_right_left, request.path); !ok) return ok.error();
  }
  if (!c.rectified) {
    const std::optional<StereoModel> model = model_without_warp(c);
    const bool nothing_else_prescribed =
        !c.prescribed || (model && is_identity(c.prescribed->R_left) && is_identity(c.prescribed->R_right) &&
                          same_model(c.prescribed->model, *model));
    if (model && nothing_else_prescribed) {
      c.rectified = true;
      if (!c.prescribed) c.prescribed = PrescribedRectification{};
      c.prescribed->model = *model;
      if (const Result<void> ok = check_model(*model, request.path); !ok) return ok.error();
    }
  }
  return c;
}

}  // namespace cliquevo::drivers
