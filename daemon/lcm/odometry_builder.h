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

// Errors of one motion and the next are not independent: noise of the image between them moves its pose forth in the
// one and back in the other. Of motions whose covariances differ little, their correlation is taken as -kTakenBack, so
// that the variance of the sum of many grows by 1 - 2 kTakenBack of each, while that of each alone is as it was.
// Measured on the simulator's courses (tests/system/pose_covariance_test.cpp): -0.33 with the next motion, and small
// positive ones with dozens that follow it, of the same features on the same surfaces. They make up for a part: with
// this value the errors over 10 to 100 m are as large as their covariance says.
inline constexpr double kTakenBack = 0.2;

// Covariance of a pose over the way to it: of position and rotation vector along the axes of the odometry frame.
class PoseCovariance {
 public:
  PoseCovariance();  // of a start: as good as exact

  // A motion by `moved` in the body's frame, which stood along R_before. `delta`: covariance of a perturbation on the
  // motion's left. follows: the motion began where the last one that was added ended, with its last image. What this
  // gives is the covariance of errors that can be: it is positive definite whatever is added.
  void add(const Eigen::Matrix3d& R_before, const Eigen::Vector3d& moved, const Matrix6d& delta, bool follows);
  const Matrix6d& matrix() const { return matrix_; }

 private:
  Matrix6d matrix_;
  Matrix6d last_;  // a root of the last motion's covariance, as it moved the pose; zero: none
};

class OdometryBuilder {
 public:
  explicit OdometryBuilder(const RigidTransform& T_body_camera);

  // usable: motion and pose of the frame are finite; else it is sent like a failed one. No allocation.
  void build(const PublishedFrame& frame, bool usable, TimestampNs publish_ns, odometry_t& out);

 private:
  struct State {
    RigidTransform T_odom_body;
    PoseCovariance covariance;
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
