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

// How errors of successive motions go together, as measured on the simulator's courses, in units of each motion's
// covariance (tests/system/pose_covariance_test.cpp prints both).
// A motion's error has three parts: noise of the image that it ends in, which the next motion takes back; that of the
// image before, which it takes back itself; and one of its own. The first and the last are alike, so that of motions
// with equal covariances each part has a third: successive errors correlate by -1/3. A blurred picture makes the
// covariance of two motions large, and about half of what it adds to the pose is gone with the second.
inline constexpr double kLeastNew = 0.1;  // share of a motion's variance, at least, that is not of the image before
// Noise of the image is taken back but for a small part; that of alignment, which depends on the surfaces, is not. With
// (expected error / that of alignment)^2 - 1 = x, the lasting part of a motion's own variance is kLasting / (1 + kWhite
// x^2): all of it on a clean camera, half of it on a webcam.
inline constexpr double kWhite = 0.36;
inline constexpr double kLasting = 1.02;
// The same features on the same surfaces, and what is left of the calibration's errors: a share kShared of the variance
// of each motion's own part is of errors that many motions have in common, and that fade over kSharedMotions of them.
inline constexpr double kShared = 0.0105;
inline constexpr double kSharedMotions = 100.0;

// Covariance of a pose over the way to it: of position and rotation vector along the axes of the odometry frame.
class PoseCovariance {
 public:
  enum class Motion {
    next,       // measured from where the last one that was added ended
    after_gap,  // measured, but from elsewhere or across frames that failed
    guess
  };

  PoseCovariance();  // of a start: as good as exact

  // A motion by `moved` in the body's frame, which stood along R_before. `delta`: covariance of a perturbation on the
  // motion's left. `lasting`: the part of its own variance that later motions do not take back (lasting_part()). What
  // this gives is the covariance of errors that can be: it is positive definite whatever is added.
  void add(const Eigen::Matrix3d& R_before, const Eigen::Vector3d& moved, const Matrix6d& delta, double lasting,
           Motion motion);
  // expected_error_px: of reprojection, as the camera's noise has it; 0 where nothing is known of it.
  static double lasting_part(double expected_error_px);
  const Matrix6d& matrix() const { return matrix_; }

 private:
  Matrix6d matrix_;    // all of it
  Matrix6d lasting_;   // without the noise of the last image
  double last_noise_;  // of the last image, a variance in the unit of size_of() of a motion's covariance
  Matrix6d shared_;    // of the pose's error with the errors that motions share, the latter with variance 1
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
