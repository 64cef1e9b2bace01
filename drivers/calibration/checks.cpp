// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/checks.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/calibration/baseline.h"
#include "drivers/calibration/size.h"
#include "drivers/text_file.h"
#include "stereo/camera_projection.h"

namespace cliquevo::drivers {

namespace {

constexpr double kMostCoefficient = 1000.0;
constexpr double kMostOffCentre = 0.75;      // share of the side; of the whole one, so a quarter off the image
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
  if (c.width > 0 &&
      (std::abs(c.cx_px / c.width - 0.5) > kMostOffCentre || std::abs(c.cy_px / c.height - 0.5) > kMostOffCentre)) {
    return calibration_error(fmt::format("principal point {:.6g}, {:.6g} px is far off the image of {}x{}", c.cx_px,
                                         c.cy_px, c.width, c.height),
                             where);
  }
  for (const double k : c.coefficients) {
    if (!std::isfinite(k) || std::abs(k) > kMostCoefficient) {
      return calibration_error("distortion coefficient is absurd", where);
    }
  }
  return {};
}

Result<void> check_translation(const Eigen::Vector3d& t, bool unit_named, const std::string& where) {
  if (!t.allFinite()) return calibration_error("translation between the cameras is not finite", where);
  const double length = t.norm();
  if (length < 1e-9) return calibration_error("baseline is zero", where);
  if (std::abs(t.x()) < 0.5 * length) return calibration_error("cameras are not side by side", where);
  if (t.x() > 0.0) {
    return Error{"right camera lies left of the left one (cameras swapped)", where,
                 "exchange the cameras in the file, or turn R and T round if they lead from the right camera to the "
                 "left one"};
  }
  return check_baseline(length, unit_named, where);
}

bool is_undistorted(const CameraCalibration& c) {
  // Fisheyes and spheres without coefficients still bend rays.
  const bool pinhole =
      c.distortion == Distortion::none || c.distortion == Distortion::plumb_bob || c.distortion == Distortion::rational;
  return pinhole && std::all_of(c.coefficients.begin(), c.coefficients.end(), [](double k) { return k == 0.0; });
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

// The rectified cameras must differ by the baseline alone, to what files round to.
Result<void> check_fit(const PrescribedRectification& p, const RigidTransform& T_right_left, const std::string& where) {
  const Eigen::Matrix3d between = p.R_right * T_right_left.R * p.R_left.transpose();
  const Eigen::Vector3d shift = p.R_right * T_right_left.t + Eigen::Vector3d(p.model.baseline_m, 0.0, 0.0);
  if ((between - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.02 ||
      shift.norm() > 0.03 * p.model.baseline_m) {
    return calibration_error("prescribed rectification does not fit rotation and baseline of the cameras", where);
  }
  return {};
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

bool is_rotation(const Eigen::Matrix3d& R) {
  return R.allFinite() && R.determinant() > 0.0 &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance;
}

Result<void> check_rotation(const Eigen::Matrix3d& R, const std::string& where) {
  return is_rotation(R) ? Result<void>{} : calibration_error("rotation matrix is singular or no rotation", where);
}

void order_cameras(StereoCalibration& c) {
  if (!(c.T_right_left.t.x() > 0.0) || c.prescribed) return;
  std::swap(c.left, c.right);
  c.T_right_left = c.T_right_left.inverse();
  c.exchanged = true;
  c.notes.push_back(kExchangedNote);
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

Result<void> set_image_size(const Document& file, CameraCalibration& camera) {
  const auto size = file.image_size();
  if (!size) return size.error();
  if (*size) std::tie(camera.width, camera.height) = **size;
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
    if (std::abs(p[7]) > 1e-3 * std::abs(P_right[3])) return calibration_error("cameras are not side by side", where);
  }
  if (!near(P_left[0], P_right[0]) || !near(P_left[5], P_right[5]) || !near(P_left[6], P_right[6])) {
    return calibration_error("projections of the cameras have unequal focal lengths or rows", where);
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

Result<void> check_model(const StereoModel& model, const std::string& where) {
  StereoModel sized = model;
  if (sized.width <= 0) {  // no size is known yet: a stand-in that the focal length and centre must fit all the same
    sized.width = static_cast<int>(std::clamp(2.0 * model.cx_px, 16.0, 16384.0));
    sized.height = static_cast<int>(std::clamp(2.0 * model.cy_px, 16.0, 16384.0));
  }
  if (const Result<void> ok = sized.check(); !ok) return calibration_error(ok.error().where, where);
  return {};
}

Result<std::vector<double>> calibration_numbers(std::string_view text, const std::string& where) {
  Result<std::vector<double>> values = parse_numbers(text, "calibration", where);
  if (!values) return values;
  for (const double value : *values) {
    if (!(std::abs(value) <= 1e9)) {
      return calibration_error(fmt::format("calibration holds {:.3g}, which is absurd", value), where);
    }
  }
  return values;
}

namespace {

void scale_lengths(StereoCalibration& c, double by) {
  c.T_right_left.t *= by;
  if (c.prescribed) c.prescribed->model.baseline_m *= by;
}

// Lengths to metres: the unit that was named, or thousandths, which no two lenses can be apart.
void settle_unit(StereoCalibration& c, const CalibrationRequest& request, double format_unit_m) {
  if (request.options.baseline_unit_m > 0.0) {
    scale_lengths(c, request.options.baseline_unit_m / format_unit_m);
    return;
  }
  const double length = c.T_right_left.t.norm();
  constexpr double kApart_m = 0.001;
  if (!(length >= 1.5e-5 && length < 0.8 * kApart_m)) return;
  scale_lengths(c, 1000.0);
  c.notes.push_back(
      fmt::format("baseline of {:.4g} m in {} taken for {:.4g} m (it was divided by 1000); "
                  "--baseline-unit 1 if not",
                  length, request.path, 1000.0 * length));
}

Result<void> check_prescribed(StereoCalibration& c, const CalibrationRequest& request) {
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
  return check_fit(p, c.T_right_left, request.path);
}

// The pair that this calibration rectifies to, for images that are it.
Result<StereoCalibration> rectified_already(StereoCalibration c, const CalibrationRequest& request) {
  if (!c.prescribed) {
    return Error{"calibration does not describe the rectified cameras", request.path,
                 "name a file with the projections of the rectified images (P1 and P2; KITTI's calib.txt)"};
  }
  StereoModel m = c.prescribed->model;
  if (request.width > 0 && (m.width != request.width || m.height != request.height)) {
    return size_error(request.path + " (rectified)", m.width, m.height, request.width, request.height);
  }
  c.left = {m.width, m.height, m.fx_px, m.fy_px, m.cx_px, m.cy_px, Distortion::none, {}, {}};
  c.right = c.left;
  c.right.cx_px += m.doffs_px;
  c.T_right_left = {Eigen::Matrix3d::Identity(), {-m.baseline_m, 0.0, 0.0}};
  c.prescribed = PrescribedRectification{};
  c.prescribed->model = m;
  c.rectified = true;
  return c;
}

}  // namespace

Result<StereoCalibration> finish_calibration(StereoCalibration c, const CalibrationRequest& request,
                                             double format_unit_m) {
  c.source = request.path;
  if (auto ok = settle_size(c, request); !ok) return ok.error();
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    const std::string where = request.path + (camera == &c.left ? " (left camera)" : " (right camera)");
    if (const Result<void> ok = check_camera(*camera, where); !ok) return ok.error();
    if (const Result<void> ok = check_lens(*camera, where); !ok) return ok.error();
  }
  if (const Result<void> ok = check_rotation(c.T_right_left.R, request.path + " (left to right)"); !ok) {
    return ok.error();
  }
  settle_unit(c, request, format_unit_m);
  if (auto ok = check_translation(c.T_right_left.t, request.options.baseline_unit_m > 0.0, request.path); !ok) {
    return ok.error();
  }
  c.T_right_left = c.T_right_left.normalized();
  if (c.prescribed) {
    if (auto ok = check_prescribed(c, request); !ok) return ok.error();
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
  c.readout_s = 1e-3 * request.options.readout_ms;
  return request.options.rectified && !c.rectified ? rectified_already(std::move(c), request) : c;
}

}  // namespace cliquevo::drivers
