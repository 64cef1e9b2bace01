// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSmooth_s = 0.2;  // over which velocity is averaged: noise and gait go, turns stay
// In which an unconfirmed velocity falls to 1/e: vehicles keep their speed for longer than their turns.
constexpr double kFadeSpeed_s = 20.0;
constexpr double kFadeTurn_s = 3.0;
constexpr double kSpeed_m_s = 5.0;    // of a vehicle of which nothing is known yet
constexpr double kTurn_rad_s = 0.25;  // what a vehicle that drove straight may do next
constexpr double kLeastMoved_m = 0.05;
constexpr double kLeastTurned_rad = 0.01;

// For how long, in all, a velocity counts in a gap when it fades with a time constant.
double faded_s(double elapsed_s, double fade_s) { return fade_s * (1.0 - std::exp(-elapsed_s / fade_s)); }

}  // namespace

void DeadReckoning::reset() {
  last_motion_ = {};
  interval_ns_ = 0;
  twist_.setZero();
}

void DeadReckoning::learn(const RigidTransform& motion, TimestampNs interval_ns) {
  if (interval_ns <= 0) return;
  const double seconds = static_cast<double>(interval_ns) * 1e-9;
  Vector6d twist;
  twist << motion.t / seconds, so3_log(motion.R) / seconds;
  const double share = interval_ns_ > 0 ? 1.0 - std::exp(-seconds / kSmooth_s) : 1.0;
  twist_ += share * (twist - twist_);
  last_motion_ = motion;
  interval_ns_ = interval_ns;
}

RigidTransform DeadReckoning::prediction(TimestampNs elapsed_ns) const {
  RigidTransform step;
  if (interval_ns_ <= 0) return step;
  const double share = static_cast<double>(elapsed_ns) / static_cast<double>(interval_ns_);
  step.R = so3_exp(share * so3_log(last_motion_.R));
  step.t = share * last_motion_.t;
  return step;
}

RigidTransform DeadReckoning::guess(TimestampNs elapsed_ns, TimestampNs since_valid_ns, Vector6d& variance) const {
  const double elapsed_s = static_cast<double>(elapsed_ns) * 1e-9;
  RigidTransform step;
  if (params_.after_failure == AfterFailure::constant_velocity && interval_ns_ > 0) {
    const double since_valid_s = static_cast<double>(since_valid_ns) * 1e-9;
    step.t = elapsed_s * std::exp(-since_valid_s / kFadeSpeed_s) * twist_.head<3>();
    step.R = so3_exp(elapsed_s * std::exp(-since_valid_s / kFadeTurn_s) * twist_.tail<3>());
  }
  // As uncertain as if the vehicle had stopped, or gone twice as fast, or begun to turn.
  const double unknown = interval_ns_ > 0 ? elapsed_s * twist_.head<3>().norm() : kSpeed_m_s * elapsed_s;
  const double moved = std::max(kLeastMoved_m, unknown);
  const double turned =
      std::max({kLeastTurned_rad, elapsed_s * twist_.tail<3>().norm(), std::min(kPi, kTurn_rad_s * elapsed_s)});
  variance << Eigen::Vector3d::Constant(moved * moved), Eigen::Vector3d::Constant(turned * turned);
  return step;
}

RigidTransform DeadReckoning::across(const RigidTransform& guessed, TimestampNs gap_ns, const RigidTransform& after,
                                     TimestampNs after_ns) const {
  const bool moves_on = params_.after_failure == AfterFailure::constant_velocity;
  if (!moves_on || knows_speed() || after_ns <= 0 || gap_ns <= 0) return guessed;
  const double gap_s = static_cast<double>(gap_ns) * 1e-9;
  const double after_s = static_cast<double>(after_ns) * 1e-9;
  RigidTransform motion;
  motion.t = faded_s(gap_s, kFadeSpeed_s) / after_s * after.t;
  motion.R = so3_exp(faded_s(gap_s, kFadeTurn_s) / after_s * so3_log(after.R));
  return motion;
}

}  // namespace cliquevo::vo
