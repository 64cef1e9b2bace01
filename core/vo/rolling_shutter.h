// SPDX-License-Identifier: BSD-3-Clause
// Rolling shutters expose a picture's rows one after the other, so that each sees from another place. What a row sees
// is moved to the frame's stamp, the time of its middle row, by the velocity that the camera has then (Hedborg et al.,
// Rolling shutter bundle adjustment, 2012; first order in the time of the readout).
#pragma once

#include <vector>

#include "core/base/camera_model.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/motion.h"

namespace cliquevo::vo {

// [translation, rotation] a second, in the camera's own frame.
using Velocity = Vector6d;

class RollingShutter {
 public:
  explicit RollingShutter(const StereoModel& model) : readout_s_(model.readout_s), height_px_(model.height) {}

  bool rolls() const { return readout_s_ > 0.0; }
  // Of a row, against the frame's stamp.
  double later_s(double row_px) const { return readout_s_ * ((row_px + 0.5) / height_px_ - 0.5); }
  // Where the camera is when it exposes this row, in its frame at the stamp.
  RigidTransform T_stamp_row(const Velocity& velocity, double row_px) const;
  // (u, v, disparity) as they would be if the whole picture were exposed at its stamp.
  Eigen::Vector3d at_stamp(const StereoModel& model, const Velocity& velocity, const Eigen::Vector3d& uvd) const;

 private:
  double readout_s_;
  int height_px_;
};

// Mean velocity over an interval.
Velocity velocity_of(const RigidTransform& motion, TimestampNs interval_ns);

// How fast the camera turned during the current frame's exposure, beyond its velocity: vibration that the
// motions between frames do not show bends the picture.
struct TurnFit {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // rad/s
  Matrix6d covariance = Matrix6d::Zero();          // of the motion (as Motion::covariance), for not knowing it better
};
// Least squares of the motion and the rate together over the inliers, from a solution on. prior_rad_s: how fast a turn
// is expected.
TurnFit fit_turn(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                 const Motion& motion, const StereoModel& model, const Sigmas& sigmas, double prior_rad_s);

}  // namespace cliquevo::vo
