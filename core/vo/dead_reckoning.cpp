// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/dead_reckoning.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {

constexpr double kPi = 3.14159265358979323846;
// Over which velocity is averaged: usually kSmooth_s[kUsual], unless another one predicted stretches of kStretch_s
// plainly better of late.
constexpr std::array<double, 4> kSmooth_s{0.0, 0.1, 0.2, 0.4};
constexpr std::size_t kUsual = 2;
constexpr double kPlainlyBetter = 0.7;  // mean square of what it was off by, over the usual one's
constexpr double kStretch_s = 0.5;
constexpr double kMemory_s = 5.0;
// In which an unconfirmed velocity falls to 1/e. A speed is kept for some seconds and is no longer known after many; a
// turn may end at any moment.
constexpr double kFadeSpeed_s = 20.0;
constexpr double kFadeTurn_s = 2.0;
constexpr double kSpeed_m_s = 5.0;    // of a vehicle of which nothing is known yet
constexpr double kTurn_rad_s = 0.25;  // what a vehicle that drove straight may do next
constexpr double kLeastMoved_m = 0.05;
constexpr double kLeastTurned_rad = 0.01;

// What is left of a velocity, little less at first; and its integral: for how long, in all, it counts in a gap.
double left(double since_s, double fade_s) { return std::exp(-(since_s / fade_s) * (since_s / fade_s)); }
double faded_s(double gap_s, double fade_s) { return 0.5 * std::sqrt(kPi) * fade_s * std::erf(gap_s / fade_s); }

template <std::size_t N>
std::size_t best(const std::array<double, N>& errors) {
  const auto least = static_cast<std::size_t>(std::min_element(errors.begin(), errors.end()) - errors.begin());
  return errors[least] < kPlainlyBetter * errors[kUsual] ? least : kUsual;
}

}  // namespace

void DeadReckoning::reset() {
  last_motion_ = {};
  interval_ns_ = 0;
  moved_.setZero();
  moved_s_ = 0.0;
  known_s_ = 0.0;
  judged_ = 0;
  speed_error_.fill(0.0);
  turn_error_.fill(0.0);
}

void DeadReckoning::learn(const RigidTransform& motion, TimestampNs interval_ns) {
  if (interval_ns <= 0) return;
  const double seconds = static_cast<double>(interval_ns) * 1e-9;
  Vector6d twist;
  twist << motion.t / seconds, so3_log(motion.R) / seconds;
  const bool first = interval_ns_ == 0;
  if (first) velocities_.fill(twist);
  for (std::size_t i = 0; i < kVelocities; ++i) {
    const double share = kSmooth_s[i] > 0.0 ? 1.0 - std::exp(-seconds / kSmooth_s[i]) : 1.0;
    velocities_[i] += share * (twist - velocities_[i]);
  }
  last_motion_ = motion;
  interval_ns_ = interval_ns;
  if (!first) known_s_ += seconds;
  if (known_s_ > kSmooth_s.back()) {  // before, all are the first motion's
    moved_ += seconds * twist;
    moved_s_ += seconds;
    if (moved_s_ < kStretch_s) return;
    judge(moved_ / moved_s_, moved_s_);
  }
  at_begin_ = velocities_;
  moved_.setZero();
  moved_s_ = 0.0;
}

void DeadReckoning::judge(const Vector6d& mean_twist, double seconds) {
  ++judged_;
  const double share = std::max(1.0 / judged_, 1.0 - std::exp(-seconds / kMemory_s));  // a plain mean at first
  for (std::size_t i = 0; i < kTurns; ++i) {
    const Vector6d off = i < kVelocities ? Vector6d(mean_twist - at_begin_[i]) : mean_twist;
    turn_error_[i] += share * (off.tail<3>().squaredNorm() - turn_error_[i]);
    if (i < kVelocities) speed_error_[i] += share * (off.head<3>().squaredNorm() - speed_error_[i]);
  }
}

Vector6d DeadReckoning::twist() const {
  Vector6d out = Vector6d::Zero();
  if (!knows_speed()) return out;
  if (judged_ == 0) return velocities_[kUsual];
  out.head<3>() = velocities_[best(speed_error_)].head<3>();
  const std::size_t turn = best(turn_error_);
  if (turn < kVelocities) out.tail<3>() = velocities_[turn].tail<3>();
  return out;
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
  const Vector6d now = twist();
  if (params_.after_failure == AfterFailure::constant_velocity && interval_ns_ > 0) {
    const double since_valid_s = static_cast<double>(since_valid_ns) * 1e-9;
    step.t = elapsed_s * left(since_valid_s, kFadeSpeed_s) * now.head<3>();
    step.R = so3_exp(elapsed_s * left(since_valid_s, kFadeTurn_s) * now.tail<3>());
  }
  // As uncertain as if the vehicle had stopped, or gone twice as fast, or begun to turn.
  const double unknown = interval_ns_ > 0 ? elapsed_s * now.head<3>().norm() : kSpeed_m_s * elapsed_s;
  const double moved = std::max(kLeastMoved_m, unknown);
  const double turned =
      std::max({kLeastTurned_rad, elapsed_s * now.tail<3>().norm(), std::min(kPi, kTurn_rad_s * elapsed_s)});
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
