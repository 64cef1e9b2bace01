// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/camera_clock.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::drivers {

namespace {

// All in periods unless stated. How they depend on each other: a step that leaves the stamps on the grid (within
// kOnGrid plus the jitter of 0.1) and is not zero is at least kLeastStep. It moves a frame's arrival - stamp by as much
// against the mean, so a frame nearer to the mean than that less all noise has seen no step: on_time(). Nothing arrives
// before it is sent, so one that is kEarly has seen a step forward. A late one alone may pass for on time after a step
// forward, which looks like frames missing: where numbers are left out two frames must be on time.
constexpr double kOnGrid = 0.15;
constexpr double kOnGridAtFirst = 0.25;  // the grid itself stands on few jittered stamps
constexpr double kLeastStep = 0.70;      // 1 - kOnGrid - 0.1, and the error of the mean
constexpr double kEarly = 0.6;           // noise of 0.5, and the error of the mean
constexpr double kLeastOnTime = 0.15;
constexpr double kMostOnTime = 0.5;
constexpr double kFarOffAtFirst = 1.2;  // two frames on an unstepped clock, apart as far as can be
constexpr double kMostDrift = 0.02;     // of the nominal period
constexpr int kMostGap = 64;            // further on, the error of the tracked period would count
constexpr int kIrregularToRestart = 4;
constexpr int kUnconfirmedToRestart = 64;
constexpr int kLeastFramesToLock = 24;
constexpr int kMostFramesToLock = 400;
constexpr std::int64_t kMostStamp = 4'000'000'000'000'000'000;  // ns, year 2096
constexpr double kGridGain = 0.05;
constexpr double kPeriodGain = 0.00125;
constexpr double kDelayGain = 1.0 / 64.0;

}  // namespace

bool CameraClock::was_here(TimestampNs stamp_ns) {
  const auto end = recent_.begin() + static_cast<std::ptrdiff_t>(std::min(recent_count_, kRecent));
  if (std::find(recent_.begin(), end, stamp_ns) != end) return true;
  recent_[recent_count_++ % kRecent] = stamp_ns;
  return false;
}

CameraClock::Reading CameraClock::begin(TimestampNs stamp_ns, std::int64_t arrival_ns, bool restarted) {
  base_ns_ = stamp_ns;
  base_delay_ns_ = arrival_ns - stamp_ns;
  period_ns_ = nominal_ns_;
  grid_ns_ = 0.0;
  newest_ = 0;
  seen_ = 1;
  delay_ns_ = least_delay_ns_ = most_delay_ns_ = 0.0;
  frames_ = 1;
  irregular_ = doubts_ = unconfirmed_ = collected_ = 0;
  late_sum_ = spread_sum_ = 0.0;
  locked_ = false;
  Reading reading;
  reading.restarted = restarted;
  return reading;
}

CameraClock::Reading CameraClock::read(TimestampNs stamp_ns, std::int64_t arrival_ns) {
  if (was_here(stamp_ns)) {
    Reading reading;
    reading.verdict = Verdict::doubled;
    return reading;
  }
  if (std::abs(stamp_ns / 2) > kMostStamp / 2) return {};  // differences of such would overflow
  if (frames_ == 0) return begin(stamp_ns, arrival_ns, false);
  const double ahead_ns = static_cast<double>(stamp_ns - base_ns_) - grid_ns_;
  // Too far for the tracked period, or for a sane number at all.
  if (std::abs(ahead_ns) > (kMostGap + 0.5) * period_ns_) return begin(stamp_ns, arrival_ns, true);
  const std::int64_t step = std::llround(ahead_ns / period_ns_);
  const double residual_ns = ahead_ns - static_cast<double>(step) * period_ns_;
  const double delay_ns = static_cast<double>(arrival_ns - stamp_ns - base_delay_ns_);
  const double on_grid = !locked_ && frames_ < 16 ? kOnGridAtFirst : kOnGrid;
  if (std::abs(residual_ns) > on_grid * nominal_ns_) {
    doubt();
    if (++irregular_ >= kIrregularToRestart) return begin(stamp_ns, arrival_ns, true);
    return {};
  }
  if (locked_) irregular_ = 0;
  return locked_ ? number(step, residual_ns, delay_ns, stamp_ns, arrival_ns)
                 : learn(step, residual_ns, delay_ns, stamp_ns, arrival_ns);
}

void CameraClock::advance(std::int64_t step, double residual_ns) {
  // Least squares over the first frames, whose gains come down to those of the steady state.
  const double n = frames_ + 1.0;
  const double gain = std::max(kGridGain, 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)));
  const double period_gain = std::max(kPeriodGain, 6.0 / (n * (n + 1.0)));
  grid_ns_ += static_cast<double>(step) * period_ns_ + gain * residual_ns;
  period_ns_ = std::clamp(period_ns_ + period_gain * residual_ns / static_cast<double>(step),
                          (1.0 - kMostDrift) * nominal_ns_, (1.0 + kMostDrift) * nominal_ns_);
  newest_ += step;
  seen_ = (step >= 64 ? 0 : seen_ << static_cast<unsigned>(step)) | 1U;
}

CameraClock::Reading CameraClock::learn(std::int64_t step, double residual_ns, double delay_ns, TimestampNs stamp_ns,
                                        std::int64_t arrival_ns) {
  if (std::abs(delay_ns - delay_ns_) > kFarOffAtFirst * nominal_ns_) {  // late, or a step; or the first ones were late
    if (++irregular_ >= kIrregularToRestart) return begin(stamp_ns, arrival_ns, true);
    return {};
  }
  irregular_ = 0;
  if (step >= 1) advance(step, residual_ns);
  ++frames_;
  delay_ns_ += (delay_ns - delay_ns_) / frames_;
  least_delay_ns_ = std::min(least_delay_ns_, delay_ns);
  most_delay_ns_ = std::max(most_delay_ns_, delay_ns);
  // The two means together must be good to 0.3 periods at six sigma, from the width of an even distribution.
  const double width = (most_delay_ns_ - least_delay_ns_) / nominal_ns_;
  const int needed =
      static_cast<int>(std::clamp(66.0 * width * width, double{kLeastFramesToLock}, double{kMostFramesToLock}));
  if (frames_ >= needed) {
    locked_ = true;
    spread_ = 0.25 * width;  // of an even distribution
    doubt();
  }
  return {};
}

CameraClock::Reading CameraClock::number(std::int64_t step, double residual_ns, double delay_ns, TimestampNs stamp_ns,
                                         std::int64_t arrival_ns) {
  const double late = (delay_ns - delay_ns_) / nominal_ns_;
  if (late < -kEarly) return begin(stamp_ns, arrival_ns, true);
  Reading reading;
  reading.index = newest_ + step;
  if (step <= 0) {
    const std::uint64_t bit = step > -64 ? std::uint64_t{1} << static_cast<unsigned>(-step) : 0;
    const bool taken = (seen_ & bit) != 0 || bit == 0;
    seen_ |= bit;
    doubt();  // a late frame, or a clock that was set back
    if (++unconfirmed_ > kUnconfirmedToRestart) return begin(stamp_ns, arrival_ns, true);
    reading.out_of_order = !taken;
    reading.verdict = taken ? Verdict::uncertain : Verdict::held;
    return reading;
  }
  ++frames_;
  advance(step, residual_ns);
  if (step > 1) {
    reading.missing = step - 1;
    doubt();
  } else if (doubts_ == 0 && late > on_time()) {
    doubts_ = 1;  // a step back might stand for frames that are missing
  }
  collect_delay(late);
  if (doubts_ > 0 && std::abs(late) <= on_time() && --doubts_ == 0) reading.confirms = true;
  if (doubts_ == 0) {
    follow_delay();
    unconfirmed_ = 0;
    reading.verdict = Verdict::certain;
    return reading;
  }
  if (++unconfirmed_ > kUnconfirmedToRestart) return begin(stamp_ns, arrival_ns, true);
  reading.verdict = Verdict::held;
  return reading;
}

void CameraClock::doubt() { doubts_ = 2; }

double CameraClock::on_time() const {
  return std::clamp(kLeastStep - (3.0 * spread_ + 0.05), kLeastOnTime, kMostOnTime);
}

// Only frames that come to be certain count for the delay; but then all of them, or the mean would favour early ones.
void CameraClock::collect_delay(double late) {
  if (std::abs(late) > kEarly) return;  // a stalled host must not pull the mean
  ++collected_;
  late_sum_ += late;
  spread_sum_ += std::abs(late);
}

void CameraClock::follow_delay() {
  if (collected_ > 0) {
    const double gain = 1.0 - std::pow(1.0 - kDelayGain, collected_);
    delay_ns_ += gain * late_sum_ / collected_ * nominal_ns_;
    spread_ += gain * (spread_sum_ / collected_ - spread_);
  }
  collected_ = 0;
  late_sum_ = spread_sum_ = 0.0;
}

}  // namespace cliquevo::drivers
