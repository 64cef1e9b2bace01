// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectification.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/LU>

#include "stereo/camera_projection.h"

namespace cliquevo::stereo {

namespace {

constexpr char kRemedy[] = "calibrate the cameras again or name the right calibration file";

Error bad(const StereoCalibration& calibration, const char* why) {
  return {"cannot rectify with this calibration", calibration.source.empty() ? why : calibration.source + ", " + why,
          kRemedy};
}

bool is_rotation(const Eigen::Matrix3d& R) {
  if (!R.allFinite()) return false;
  // Files carry six digits or so; anything beyond a thousandth is no rounding.
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0;
}

double radians(double degrees) { return degrees * M_PI / 180.0; }

// The same view's middle with another horizontal field of view.
void set_fov(StereoModel& m, double fov_deg) {
  const double half_width = 0.5 * (m.width - 1);
  const double half_height = 0.5 * (m.height - 1);
  const double middle = (half_width - m.cx_px) / m.fx_px;  // tangents
  double low = 0.0;
  double high = 1e3;
  for (int i = 0; i < 100; ++i) {  // of half the view's width
    const double half = 0.5 * (low + high);
    const double fov = std::atan(middle + half) - std::atan(middle - half);
    (fov < radians(fov_deg) ? low : high) = half;
  }
  const double ratio = half_width / high / m.fx_px;
  m.fx_px *= ratio;
  m.fy_px *= ratio;
  m.doffs_px *= ratio;
  m.cx_px = half_width - ratio * (half_width - m.cx_px);
  m.cy_px = half_height - ratio * (half_height - m.cy_px);
}

// Pixels of another size; the corner of the first one stays where it is.
void set_scale(StereoModel& m, double scale) {
  m.width = static_cast<int>(std::lround(m.width * scale));
  m.height = static_cast<int>(std::lround(m.height * scale));
  m.fx_px *= scale;
  m.fy_px *= scale;
  m.doffs_px *= scale;
  m.cx_px = (m.cx_px + 0.5) * scale - 0.5;
  m.cy_px = (m.cy_px + 0.5) * scale - 0.5;
}

// Pixels a radian in the middle of the image over the focal length: the sphere models' own is another one.
double central_scale(const CameraCalibration& c) {
  const bool through_sphere = c.distortion == Distortion::unified || c.distortion == Distortion::double_sphere;
  return through_sphere ? 1.0 / (1.0 + c.coefficients[0]) : 1.0;
}

// Both cameras and how they are turned; answers how much of a pinhole image they fill.
struct Pair {
  CameraProjection left, right;
  const StereoCalibration& calibration;
  Eigen::Matrix3d R_left, R_right;

  bool sees(const CameraProjection& projection, const CameraCalibration& camera, const Eigen::Matrix3d& R, double x,
            double y) const {
    const auto p = projection.project(R.transpose() * Eigen::Vector3d(x, y, 1.0));
    // A tenth of a pixel inside: the outline is only sampled.
    return p && p->x() >= 0.1 && p->y() >= 0.1 && p->x() <= camera.width - 1.1 && p->y() <= camera.height - 1.1;
  }
  // The outline of an image of this focal length about (x0, y0), seen by both cameras all along.
  bool filled(double f, double x0, double y0) const {
    const double half_width = 0.5 * (calibration.left.width - 1) / f;
    const double half_height = 0.5 * (calibration.left.height - 1) / f;
    constexpr int kSteps = 64;
    for (int i = 0; i <= kSteps; ++i) {
      const double s = 2.0 * i / kSteps - 1.0;
      const Eigen::Vector2d outline[] = {{x0 + s * half_width, y0 - half_height},
                                         {x0 + s * half_width, y0 + half_height},
                                         {x0 - half_width, y0 + s * half_height},
                                         {x0 + half_width, y0 + s * half_height}};
      for (const Eigen::Vector2d& p : outline) {
        if (!sees(left, calibration.left, R_left, p.x(), p.y())) return false;
        if (!sees(right, calibration.right, R_right, p.x(), p.y())) return false;
      }
    }
    return true;
  }
  // Shortest focal length in [shortest, longest] that is filled; just above longest when none is.
  double shortest_focal_length(double shortest, double longest, double x0, double y0) const {
    if (filled(shortest, x0, y0)) return shortest;
    if (!filled(longest, x0, y0)) return longest * 1.001;
    double low = shortest;
    double high = longest;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (filled(middle, x0, y0) ? high : low) = middle;
    }
    return high;
  }
};

// The shortest rotation that brings the direction to the X axis.
Eigen::Matrix3d turn_to_x(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis = direction.cross(Eigen::Vector3d::UnitX());
  const double sine = axis.norm();
  const Eigen::Vector3d level = sine > 1e-12 ? Eigen::Vector3d(axis / sine * std::asin(std::min(1.0, sine)))
                                             : Eigen::Vector3d(Eigen::Vector3d::Zero());
  return so3_exp(level);
}

// The shortest focal length that leaves no border without a source; moves the middle where that lets it show more.
double fit_focal_length(const Pair& pair, const StereoCalibration& calibration, Eigen::Vector2d& middle) {
  const CameraCalibration& l = calibration.left;
  const CameraCalibration& r = calibration.right;
  const double raw_f =
      0.25 * (l.fx_px * central_scale(l) + l.fy_px * central_scale(l) + r.fx_px * central_scale(r) * l.width / r.width +
              r.fy_px * central_scale(r) * l.width / r.width);
  const double widest = 0.5 * (calibration.left.width - 1) / std::tan(radians(0.5 * RectifyParams::kMostFovDeg));
  const double shortest = std::max(0.75 * raw_f, widest);
  const double longest = std::max(1.5 * raw_f, widest);
  double f = pair.shortest_focal_length(shortest, longest, middle.x(), middle.y());
  for (double step = 0.05; step > 1e-4 && f > shortest; step *= 0.5) {
    for (const Eigen::Vector2d& d :
         {Eigen::Vector2d(step, 0), Eigen::Vector2d(-step, 0), Eigen::Vector2d(0, step), Eigen::Vector2d(0, -step)}) {
      const Eigen::Vector2d trial = middle + d;
      if (!pair.filled(f, trial.x(), trial.y())) continue;  // nor with a shorter one
      const double f_trial = pair.shortest_focal_length(shortest, longest, trial.x(), trial.y());
      if (f_trial < f) {
        f = f_trial;
        middle = trial;
      }
    }
  }
  if (f > longest) f = std::max(raw_f, widest);  // borders cannot be avoided: keep the pixels' size at least
  return f;
}

Result<PrescribedRectification> own_rectification(const StereoCalibration& calibration) {
  const RigidTransform& T = calibration.T_right_left;
  const Eigen::Vector3d turn = so3_log(T.R);
  if (turn.norm() > M_PI / 3.0) return bad(calibration, "the cameras look different ways (more than 60 degrees apart)");
  const Eigen::Matrix3d half = so3_exp(0.5 * turn);
  // The right camera's place in the frame half-way between both cameras.
  const Eigen::Vector3d baseline = -(half.transpose() * T.t);
  const Eigen::Vector3d e = baseline.normalized();
  if (e.x() < 0.0) return bad(calibration, "the right camera is left of the left one (are the cameras swapped?)");
  if (e.x() < 0.7) return bad(calibration, "the cameras are not side by side");
  const Eigen::Matrix3d R_level = turn_to_x(e);

  PrescribedRectification out;
  out.R_left = R_level * half;
  out.R_right = R_level * half.transpose();
  const Pair pair{CameraProjection(calibration.left), CameraProjection(calibration.right), calibration, out.R_left,
                  out.R_right};

  // Where the middles of both raw images end up.
  const auto middle_left = pair.left.direction(0.5 * (calibration.left.width - 1), 0.5 * (calibration.left.height - 1));
  const auto middle_right =
      pair.right.direction(0.5 * (calibration.right.width - 1), 0.5 * (calibration.right.height - 1));
  if (!middle_left || !middle_right) return bad(calibration, "the distortion leaves the middle of the image unseen");
  const Eigen::Vector3d m_left = out.R_left * *middle_left;
  const Eigen::Vector3d m_right = out.R_right * *middle_right;
  if (m_left.z() < 0.2 || m_right.z() < 0.2) return bad(calibration, "a camera looks along the baseline");
  Eigen::Vector2d middle = 0.5 * (m_left.head<2>() / m_left.z() + m_right.head<2>() / m_right.z());

  const double f = fit_focal_length(pair, calibration, middle);

  StereoModel& m = out.model;
  m.width = calibration.left.width;
  m.height = calibration.left.height;
  m.fx_px = m.fy_px = f;
  m.cx_px = 0.5 * (m.width - 1) - f * middle.x();
  m.cy_px = 0.5 * (m.height - 1) - f * middle.y();
  m.baseline_m = baseline.norm();
  return out;
}

// As the calibration has it: native size, its own field of view.
Result<PrescribedRectification> native_rectification(const StereoCalibration& calibration) {
  if (calibration.rectified && calibration.prescribed) {
    if (auto ok = calibration.prescribed->model.check(); !ok) return ok.error();
    return *calibration.prescribed;
  }
  if (calibration.rectified) return bad(calibration, "the images are said to be rectified, but no model is given");
  if (auto ok = check_camera(calibration.left, "left"); !ok) return ok.error();
  if (auto ok = check_camera(calibration.right, "right"); !ok) return ok.error();
  if (calibration.prescribed) {
    const PrescribedRectification& given = *calibration.prescribed;
    if (!is_rotation(given.R_left) || !is_rotation(given.R_right)) {
      return bad(calibration, "a prescribed rotation is none");
    }
    if (auto ok = given.model.check(); !ok) return ok.error();
    return given;
  }
  const RigidTransform& T = calibration.T_right_left;
  if (!is_rotation(T.R)) return bad(calibration, "the rotation between the cameras is none");
  if (!T.t.allFinite() || T.t.norm() < 1e-6) return bad(calibration, "no baseline between the cameras");
  auto out = own_rectification(calibration);
  if (!out) return out;
  if (auto ok = out->model.check(); !ok) return ok.error();
  return out;
}

}  // namespace

Result<void> RectifyParams::check() const {
  const auto bad = [](const char* name, double value, const char* remedy) {
    return Error{"rectification parameter out of range", std::string(name) + " = " + std::to_string(value), remedy};
  };
  if (scale && !(*scale >= 0.05 && *scale <= 2.0)) return bad("scale", *scale, "give 0.05 to 2, or auto");
  if (fov_deg && !(*fov_deg >= 10.0 && *fov_deg <= 150.0)) return bad("fov_deg", *fov_deg, "give 10 to 150, or auto");
  return {};
}

Result<PrescribedRectification> choose_rectification(const StereoCalibration& calibration,
                                                     const RectifyParams& params) {
  if (auto ok = params.check(); !ok) return ok.error();
  auto out = native_rectification(calibration);
  if (!out || params.native()) return out;
  if (params.fov_deg) set_fov(out->model, *params.fov_deg);
  if (params.scale.value_or(1.0) != 1.0) set_scale(out->model, *params.scale);
  if (auto ok = out->model.check(); !ok) return ok.error();
  return out;
}

}  // namespace cliquevo::stereo
