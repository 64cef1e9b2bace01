// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/camera_projection.h"

#include <cmath>
#include <string>

namespace cliquevo::stereo {

namespace {

constexpr double kWidestRadius = 20.0;  // tan 87 degrees: no rectified image reaches farther

}  // namespace

CameraProjection::CameraProjection(const CameraCalibration& camera) : camera_(camera) {
  const double end = camera.distortion == Distortion::equidistant ? M_PI : kWidestRadius;
  constexpr int kSteps = 20000;
  largest_radius_ = end;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = end * i / kSteps;
    if (radial(r) <= radial(end * (i - 1) / kSteps)) {
      largest_radius_ = end * (i - 1) / kSteps;
      break;
    }
  }
}

// Distorted radius over the undistorted one (fisheye: over the angle), tangential part left out.
double CameraProjection::radial(double r) const {
  const auto& k = camera_.coefficients;
  const double r2 = r * r;
  switch (camera_.distortion) {
    case Distortion::none:
      break;
    case Distortion::plumb_bob:
      return r * (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])));
    case Distortion::rational:
      return r * (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    case Distortion::equidistant:
      return r * (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * (k[2] + r2 * k[3]))));
  }
  return r;
}

Eigen::Vector2d CameraProjection::distort(double x, double y) const {
  const auto& k = camera_.coefficients;
  const double r = std::hypot(x, y);
  const double scale = r > 1e-9 ? radial(r) / r : 1.0;
  return {x * scale + 2.0 * k[2] * x * y + k[3] * (r * r + 2.0 * x * x),
          y * scale + k[2] * (r * r + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

std::optional<Eigen::Vector2d> CameraProjection::project(const Eigen::Vector3d& direction) const {
  Eigen::Vector2d p;
  if (camera_.distortion == Distortion::equidistant) {
    const double across = std::hypot(direction.x(), direction.y());
    const double theta = std::atan2(across, direction.z());
    if (!(theta < largest_radius_)) return std::nullopt;
    const double scale = across > 1e-12 ? radial(theta) / across : 1.0 / direction.z();
    p = direction.head<2>() * scale;
  } else {
    if (!(direction.z() > 1e-9)) return std::nullopt;
    const double x = direction.x() / direction.z();
    const double y = direction.y() / direction.z();
    if (!(std::hypot(x, y) < largest_radius_)) return std::nullopt;
    const bool straight = camera_.distortion == Distortion::none;
    p = straight ? Eigen::Vector2d(x, y) : distort(x, y);
  }
  return Eigen::Vector2d{camera_.fx_px * p.x() + camera_.cx_px, camera_.fy_px * p.y() + camera_.cy_px};
}

std::optional<Eigen::Vector3d> CameraProjection::direction(double u, double v) const {
  // Fixed point on the pixel error: converges wherever the lens bends less than it projects.
  Eigen::Vector3d d{(u - camera_.cx_px) / camera_.fx_px, (v - camera_.cy_px) / camera_.fy_px, 1.0};
  for (int i = 0; i < 100; ++i) {
    const auto p = project(d);
    if (!p) return std::nullopt;
    const Eigen::Vector2d error{(u - p->x()) / camera_.fx_px, (v - p->y()) / camera_.fy_px};
    d.head<2>() += error;
    if (error.norm() < 1e-10) return d;
  }
  return std::nullopt;
}

Result<void> check_camera(const CameraCalibration& camera, const char* which) {
  const auto bad = [which](const char* why) {
    return Error{std::string("impossible calibration of the ") + which + " camera", why,
                 "calibrate the cameras again or name the right calibration file"};
  };
  for (const double v : {camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px}) {
    if (!std::isfinite(v)) return bad("a value is not finite");
  }
  for (const double v : camera.coefficients) {
    if (!std::isfinite(v)) return bad("a distortion coefficient is not finite");
  }
  if (camera.width < 16 || camera.height < 16 || camera.width > 16384 || camera.height > 16384) {
    return bad("image size out of 16 to 16384 px");
  }
  if (camera.fx_px < 0.05 * camera.width || camera.fx_px > 100.0 * camera.width || camera.fy_px < 0.05 * camera.width ||
      camera.fy_px > 100.0 * camera.width) {
    return bad("focal length does not fit the image width");
  }
  if (std::abs(camera.cx_px) > 4.0 * camera.width || std::abs(camera.cy_px) > 4.0 * camera.height) {
    return bad("principal point far off the image");
  }
  return {};
}

}  // namespace cliquevo::stereo
