// SPDX-License-Identifier: BSD-3-Clause
// Where the camera goes while nothing is known of it: the guess that the pose carries through failures.
#pragma once

#include <array>
#include <cstddef>

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
  // The motion that the pose makes over one failed frame, `since_valid_ns` after the last valid one: the velocity of
  // before, which fades as nothing confirms it; and by how much the covariance grows.
  RigidTransform guess(TimestampNs elapsed_ns, TimestampNs since_valid_ns, Vector6d& variance) const;
  // The motion across a gap that ended with a valid motion (`after`, over `after_ns`). Where no speed was known before,
  // it is what that motion makes of the gap; else what was guessed: one step of a walk says less than the way before.
  RigidTransform across(const RigidTransform& guessed, TimestampNs gap_ns, const RigidTransform& after,
                        TimestampNs after_ns) const;

 private:
  // Velocities (per second) that the way goes on with: as of the last motion, and smoothed over ever longer times, for
  // a walker's speed is that of his whole step and a vehicle's that of the last frame. Turning may also just end.
  static constexpr std::size_t kVelocities = 4;
  static constexpr std::size_t kTurns = kVelocities + 1;
  using Velocities = std::array<Vector6d, kVelocities>;

  // How well each would have predicted the stretch that is over.
  void judge(const Vector6d& mean_twist, double seconds);
  Vector6d twist() const;

  VoParams params_;
  RigidTransform last_motion_;
  TimestampNs interval_ns_ = 0;
  Velocities velocities_{};
  double known_s_ = 0.0;  // for how long motions were learned
  // The stretch under way: the velocities at its beginning, and its motion so far.
  Velocities at_begin_{};
  Vector6d moved_ = Vector6d::Zero();
  double moved_s_ = 0.0;
  // Mean squares of what each was off by.
  std::array<double, kVelocities> speed_error_{};
  std::array<double, kTurns> turn_error_{};
  int judged_ = 0;  // stretches
};

}  // namespace cliquevo::vo
