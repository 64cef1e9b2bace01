// SPDX-License-Identifier: BSD-3-Clause
// From a viewing direction to the raw pixel of one camera, through its lens distortion.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/base/camera_model.h"

namespace cliquevo::stereo {

class CameraProjection {
 public:
  explicit CameraProjection(const CameraCalibration& camera);

  // Raw pixel of a direction in the camera frame; none where the lens model does not reach: behind the camera, or
  // beyond the radius at which the distortion polynomial turns back and would show the picture a second time.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& direction) const;
  // Direction (z = 1) of a raw pixel near the middle of the image; none where the inversion does not converge, or the
  // pixel sees sideways and behind.
  std::optional<Eigen::Vector3d> direction(double u, double v) const;
  // Whether a lens can be so: over the inner half of the image the model is monotonic, and bends no more than three
  // times of what it projects.
  bool is_plausible() const;

 private:
  Eigen::Vector2d distort(double x, double y) const;
  double radial(double r) const;
  // Point of the plane behind the sphere(s) that a direction goes to; none beyond the model's reach.
  std::optional<Eigen::Vector2d> to_plane(const Eigen::Vector3d& direction) const;
  std::optional<Eigen::Vector3d> from_plane(double x, double y) const;
  std::optional<Eigen::Vector2d> undistort(double x, double y) const;

  CameraCalibration camera_;
  double largest_radius_ = 0.0;  // tangent of the angle (radian for the fisheye) up to which the model is monotonic
  Eigen::Matrix3d tilt_ = Eigen::Matrix3d::Identity();  // of the sensor, Distortion::thin_prism
};

// Names the first thing wrong with a raw camera.
Result<void> check_camera(const CameraCalibration& camera, const char* which);

}  // namespace cliquevo::stereo
