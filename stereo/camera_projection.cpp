// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/camera_projection.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace cliquevo::stereo {

namespace {

constexpr double kWidestRadius = 20.0;  // tan 87 degrees: no rectified image reaches farther

// Models whose first step is a sphere, not the plane of a pinhole.
bool has_sphere(Distortion model) {
  return model == Distortion::unified || model == Distortion::extended_unified || model == Distortion::double_sphere;
}

// OpenCV's tilted sensor: turned about x and y, then projected back along the optical axis.
Eigen::Matrix3d tilt_of(double tau_x, double tau_y) {
  Eigen::Matrix3d about_x, about_y, back;
  about_x << 1, 0, 0, 0, std::cos(tau_x), std::sin(tau_x), 0, -std::sin(tau_x), std::cos(tau_x);
  about_y << std::cos(tau_y), 0, -std::sin(tau_y), 0, 1, 0, std::sin(tau_y), 0, std::cos(tau_y);
  const Eigen::Matrix3d R = about_y * about_x;
  back << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  return back * R;
}

// How far behind the image plane the model sees: z > -w |d|.
double sphere_reach(double alpha) { return alpha <= 0.5 ? alpha / (1.0 - alpha) : (1.0 - alpha) / alpha; }

}  // namespace

CameraProjection::CameraProjection(const CameraCalibration& camera) : camera_(camera) {
  if (camera.distortion == Distortion::thin_prism) tilt_ = tilt_of(camera.prism[4], camera.prism[5]);
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
    case Distortion::extended_unified:
    case Distortion::double_sphere:
      break;
    case Distortion::unified:
      return r * (1.0 + r2 * (k[1] + r2 * k[2]));
    case Distortion::plumb_bob:
      return r * (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])));
    case Distortion::rational:
    case Distortion::thin_prism:
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
  if (camera_.distortion == Distortion::unified) {
    return {x * scale + 2.0 * k[3] * x * y + k[4] * (r * r + 2.0 * x * x),
            y * scale + k[3] * (r * r + 2.0 * y * y) + 2.0 * k[4] * x * y};
  }
  if (camera_.distortion == Distortion::thin_prism) {
    const auto& s = camera_.prism;
    const double r2 = r * r;
    const Eigen::Vector3d flat{x * scale + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x) + r2 * (s[0] + r2 * s[1]),
                               y * scale + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y + r2 * (s[2] + r2 * s[3]),
                               1.0};
    const Eigen::Vector3d tilted = tilt_ * flat;
    return tilted.z() != 0.0 ? Eigen::Vector2d(tilted.head<2>() / tilted.z()) : Eigen::Vector2d(tilted.head<2>());
  }
  return {x * scale + 2.0 * k[2] * x * y + k[3] * (r * r + 2.0 * x * x),
          y * scale + k[2] * (r * r + 2.0 * y * y) + 2.0 * k[3] * x * y};
}

std::optional<Eigen::Vector2d> CameraProjection::to_plane(const Eigen::Vector3d& d) const {
  const auto& k = camera_.coefficients;
  const double length = d.norm();
  if (!(length > 0.0)) return std::nullopt;
  double depth = 0.0;
  if (camera_.distortion == Distortion::double_sphere) {
    const double xi = k[0];
    const double alpha = k[1];
    const double w1 = sphere_reach(alpha);
    const double w2 = (w1 + xi) / std::sqrt(2.0 * w1 * xi + xi * xi + 1.0);
    if (!(d.z() > -w2 * length)) return std::nullopt;
    const double z = xi * length + d.z();
    depth = alpha * std::hypot(d.x(), d.y(), z) + (1.0 - alpha) * z;
  } else if (camera_.distortion == Distortion::extended_unified) {
    const double alpha = k[0];
    const double rho = std::sqrt(k[1] * d.head<2>().squaredNorm() + d.z() * d.z());
    if (!(d.z() > -sphere_reach(alpha) * rho)) return std::nullopt;
    depth = alpha * rho + (1.0 - alpha) * d.z();
  } else {
    const double xi = k[0];
    const double reach = xi <= 1.0 ? xi : 1.0 / xi;
    if (!(d.z() > -reach * length)) return std::nullopt;
    depth = d.z() + xi * length;
  }
  if (!(depth > 1e-9 * length)) return std::nullopt;
  const double x = d.x() / depth;
  const double y = d.y() / depth;
  if (camera_.distortion != Distortion::unified) return Eigen::Vector2d{x, y};
  if (!(std::hypot(x, y) < largest_radius_)) return std::nullopt;
  return distort(x, y);
}

std::optional<Eigen::Vector2d> CameraProjection::undistort(double x, double y) const {
  Eigen::Vector2d p{x, y};
  for (int i = 0; i < 200; ++i) {
    if (!(p.norm() < largest_radius_)) return std::nullopt;
    const Eigen::Vector2d error = Eigen::Vector2d{x, y} - distort(p.x(), p.y());
    p += error;
    if (error.norm() < 1e-12) return p;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> CameraProjection::from_plane(double x, double y) const {
  const auto& k = camera_.coefficients;
  Eigen::Vector3d d;
  if (camera_.distortion == Distortion::double_sphere) {
    const double xi = k[0];
    const double alpha = k[1];
    const double r2 = x * x + y * y;
    const double root = 1.0 - (2.0 * alpha - 1.0) * r2;
    if (root < 0.0) return std::nullopt;
    const double z = (1.0 - alpha * alpha * r2) / (alpha * std::sqrt(root) + 1.0 - alpha);
    const double root2 = z * z + (1.0 - xi * xi) * r2;
    if (root2 < 0.0) return std::nullopt;
    d = (z * xi + std::sqrt(root2)) / (z * z + r2) * Eigen::Vector3d(x, y, z) - Eigen::Vector3d(0.0, 0.0, xi);
  } else if (camera_.distortion == Distortion::extended_unified) {
    const double alpha = k[0];
    const double r2 = k[1] * (x * x + y * y);
    const double root = 1.0 - (2.0 * alpha - 1.0) * r2;
    if (root < 0.0) return std::nullopt;
    d = {x, y, (1.0 - alpha * alpha * r2) / (alpha * std::sqrt(root) + 1.0 - alpha)};
  } else {
    const double xi = k[0];
    const auto p = undistort(x, y);
    if (!p) return std::nullopt;
    const double r2 = p->squaredNorm();
    const double root = 1.0 + (1.0 - xi * xi) * r2;
    if (root < 0.0) return std::nullopt;
    const double lambda = (xi + std::sqrt(root)) / (1.0 + r2);
    d = {lambda * p->x(), lambda * p->y(), lambda - xi};
  }
  if (!(d.z() > 1e-9)) return std::nullopt;
  return Eigen::Vector3d(d / d.z());
}

bool CameraProjection::is_plausible() const {
  const double wide = std::max(camera_.cx_px, camera_.width - 1 - camera_.cx_px) / camera_.fx_px;
  const double high = std::max(camera_.cy_px, camera_.height - 1 - camera_.cy_px) / camera_.fy_px;
  const double half = 0.5 * std::max(wide, high);
  if (has_sphere(camera_.distortion) && camera_.distortion != Distortion::unified) {
    return project({0.1, 0.1, 1.0}).has_value();
  }
  // The radius that the model draws half-way to the border, by bisection of a function that rises.
  double low = 0.0;
  double high_r = largest_radius_;
  if (!(radial(high_r * (1.0 - 1e-9)) >= half)) return false;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high_r);
    (radial(middle) < half ? low : high_r) = middle;
  }
  if (!(low > 0.0)) return true;
  const double ratio = half / low;
  if (!(ratio > 1.0 / 3.0 && ratio < 3.0)) return false;
  // At the border a wide lens draws an angle where the pinhole draws its tangent; no lens stretches so much.
  const double border = 2.0 * half;
  if (radial(border / 3.0) > border) return false;
  if (camera_.distortion == Distortion::equidistant || camera_.distortion == Distortion::none) return true;
  // What is not radial: the shift half-way to the border must be small beside the way there.
  for (const Eigen::Vector2d& way :
       {Eigen::Vector2d(low, 0), Eigen::Vector2d(-low, 0), Eigen::Vector2d(0, low), Eigen::Vector2d(0, -low)}) {
    if (!((distort(way.x(), way.y()) - way * ratio).norm() < 0.5 * half)) return false;
  }
  return true;
}

std::optional<Eigen::Vector2d> CameraProjection::project(const Eigen::Vector3d& direction) const {
  Eigen::Vector2d p;
  if (has_sphere(camera_.distortion)) {
    const auto on_plane = to_plane(direction);
    if (!on_plane) return std::nullopt;
    p = *on_plane;
  } else if (camera_.distortion == Distortion::equidistant) {
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
  if (has_sphere(camera_.distortion)) {
    return from_plane((u - camera_.cx_px) / camera_.fx_px, (v - camera_.cy_px) / camera_.fy_px);
  }
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
  for (const double v : camera.prism) {
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
