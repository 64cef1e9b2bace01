// SPDX-License-Identifier: BSD-3-Clause
// Where the camera goes while nothing is known of it: the guess that the pose carries through failures.
#pragma once

#include <span>

#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

class DeadReckoning {
 public:
  explicit DeadReckoning(const VoParams& params) : params_(params) {}
  void reset();

  // A valid motion over an interval.
  void learn(const RigidTransform& motion, TimestampNs interval_ns);
  bool knows_speed() const { return interval_ns_ > 0; }
  const RigidTransform& last_motion() const { return last_motion_; }

  // Constant velocity as of the last valid interval: where to look.
  RigidTransform prediction(TimestampNs elapsed_ns) const;
  // The motion that the pose makes over one failed frame, `since_valid_ns` after the last valid one: the smoothed
  // velocity of before, which fades as nothing confirms it; and by how much the covariance grows.
  RigidTransform guess(TimestampNs elapsed_ns, TimestampNs since_valid_ns, Vector6d& variance) const;
  // The motion across a gap that ended with a valid motion (`after`, over `after_ns`). Where no speed was known before,
  // it is what that motion makes of the gap; else what was guessed: one step of a walk says less than the way before.
  RigidTransform across(const RigidTransform& guessed, TimestampNs gap_ns, const RigidTransform& after,
                        TimestampNs after_ns) const;

 private:
  VoParams params_;
  RigidTransform last_motion_;
  TimestampNs interval_ns_ = 0;
  Vector6d twist_ = Vector6d::Zero();  // smoothed, per second
};

}  // namespace cliquevo::vo
