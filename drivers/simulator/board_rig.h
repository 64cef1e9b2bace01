// SPDX-License-Identifier: BSD-3-Clause
// The cameras before which the simulator moves a board: lenses of every model, and where they look.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "drivers/simulator.h"
#include "stereo/camera_projection.h"

namespace cliquevo::drivers::sim {

bool is_lens_name(const std::string& name);

// Exact. rig_seed 0: the raw pair of the courses where the lens is theirs; others: lenses, centres and mounts at
// random.
StereoCalibration board_rig(const SimulatorOptions& options);

// A lens both ways, fisheyes up to behind the camera.
class SimulatedLens {
 public:
  explicit SimulatedLens(const CameraCalibration& camera) : camera_(camera), pinhole_(camera) {}
  // Pixel of a point in the camera's frame; none where the lens does not reach.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;
  // Unit vector; none where the lens shows nothing.
  std::optional<Eigen::Vector3d> direction(double u, double v) const;
  // Whether it shows the point in the image.
  bool shows(const Eigen::Vector3d& point) const;
  const CameraCalibration& camera() const { return camera_; }

 private:
  bool is_fisheye() const { return camera_.distortion == Distortion::equidistant; }

  CameraCalibration camera_;
  stereo::CameraProjection pinhole_;
};

}  // namespace cliquevo::drivers::sim
