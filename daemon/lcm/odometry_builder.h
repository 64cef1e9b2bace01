// SPDX-License-Identifier: BSD-3-Clause
// The pose with its covariance over the whole way, and the twist: what VO_ODOMETRY sends.
#pragma once

#include <cstdint>
#include <optional>

#include <cliquevo/odometry_t.hpp>

#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "daemon/pipeline/published_frame.h"

namespace cliquevo::daemon {

// Pose errors as position and rotation vector along the axes of the odometry frame: after a motion whose covariance
// `delta` is that of a perturbation on its left, in the body frame it began in.
Matrix6d accumulated(const Matrix6d& before, const Eigen::Matrix3d& R_before, const Eigen::Vector3d& moved,
                     const Matrix6d& delta);

class OdometryBuilder {
 public:
  explicit OdometryBuilder(const RigidTransform& T_body_camera);

  // usable: motion and pose of the frame are finite; else it is sent like a failed one. No allocation.
  void build(const PublishedFrame& frame, bool usable, TimestampNs publish_ns, odometry_t& out);

 private:
  struct State {
    RigidTransform T_odom_body;
    Matrix6d covariance = Matrix6d::Zero();
    TimestampNs stamp_ns = 0;
  };
  struct Twist {
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    Eigen::Vector3d rotation_rate = Eigen::Vector3d::Zero();
    Matrix6d covariance = Matrix6d::Zero();
  };
  void start(const vo::Estimate& estimate, bool usable);
  void follow(const vo::Estimate& estimate);
  void carry_on(const vo::Estimate& estimate, bool usable);
  // Whether the pose is elsewhere than where the body, shown there last, can have gone by itself.
  bool is_jump(const State& now) const;
  RigidTransform body_pose(const vo::Estimate& estimate) const;

  RigidTransform T_body_camera_;
  RigidTransform T_camera_body_;
  Matrix6d adjoint_body_camera_;
  std::optional<State> valid_;  // at the last valid frame
  State shown_;                 // what was sent last
  Twist twist_;
  bool guessed_ = false;  // shown_ is a guess
  std::int32_t resets_ = 0;
  std::int32_t reset_counter_ = 0;
};

}  // namespace cliquevo::daemon
