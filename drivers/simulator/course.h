// SPDX-License-Identifier: BSD-3-Clause
// Where the camera is at which time. World frame: X and Y level, Z up, metres.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/rigid_transform.h"
#include "drivers/simulator.h"
#include "drivers/simulator/terrain.h"

namespace cliquevo::drivers::sim {

class Course {
 public:
  explicit Course(const SimulatorOptions& options);

  // Rectified left camera in the world. `frame` may be fractional: the camera moves during an exposure.
  RigidTransform T_world_camera(double frame) const;
  // How it sits on the vehicle.
  RigidTransform T_body_camera() const;
  // Level position of the vehicle after s metres.
  Eigen::Vector2d position(double s_m) const;
  double heading(double s_m) const;
  // Length of the closed course; infinity when it is not closed.
  double lap_m() const { return lap_m_; }
  double length_m() const { return length_m_; }  // driven in options.frames
  bool moves() const { return kind_ == Kind::wheeled || kind_ == Kind::walking || kind_ == Kind::straight; }
  bool still() const { return kind_ == Kind::standing && sway_rad_ <= 0.0; }
  const Terrain& terrain() const { return terrain_; }

 private:
  enum class Kind { wheeled, walking, standing, straight, turn };
  RigidTransform T_world_body(double s_m, double extra_yaw) const;
  Eigen::Matrix3d sway(double time_s) const;

  Kind kind_ = Kind::wheeled;
  Terrain terrain_;
  double step_m_, rate_hz_, camera_height_m_, pitch_rad_, baseline_m_;
  double lap_m_ = 0.0;
  double length_m_ = 0.0;
  double phase_[4] = {};
  double sway_rad_ = 0.0;
  double sway_phase_[3][2] = {};        // about x, y, z
  std::vector<Eigen::Vector2d> nodes_;  // positions every kNodeStep along the closed course
};

}  // namespace cliquevo::drivers::sim
