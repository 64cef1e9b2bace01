// SPDX-License-Identifier: BSD-3-Clause
// One camera's frames on its own clock: which exposure of the regular sequence each frame is, and how sure that is.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/time.h"

namespace cliquevo::drivers {

// Exposures follow each other regularly, so a stamp gives its exposure's number (index) on a grid that is tracked with
// its period. A step of the clock by almost a whole number of periods looks like frames missing or repeated. It moves
// the stamps against the arrivals, though, so a number is certain once a frame at or behind it arrives when an
// clock without a step confirms it: mostly the frame itself, at once. Until then it is held. Bounds on the noise within
// which what is called certain is right, in periods: stamps +-0.1, arrivals +-0.4 but for single frames that may be any
// amount late; pace against the nominal rate 1 %.
class CameraClock {
 public:
  enum class Verdict {
    certain,    // `index` is right; with `confirms`, so are those held before
    held,       // probably right: a later frame confirms it, or a restart revokes it
    uncertain,  // no number, or one that nothing will confirm
    doubled,    // this very frame (its stamp) was here before
  };
  struct Reading {
    Verdict verdict = Verdict::uncertain;
    std::int64_t index = 0;
    bool confirms = false;
    bool restarted = false;  // numbers begin anew: what was held is void
    bool out_of_order = false;
    std::int64_t missing = 0;  // numbers left out just before this one
  };

  explicit CameraClock(double period_ns) : nominal_ns_(period_ns), period_ns_(period_ns) {}

  // A frame's stamp on the camera's clock and its arrival on the host's.
  Reading read(TimestampNs stamp_ns, std::int64_t arrival_ns);
  void restart() { frames_ = 0, locked_ = false, irregular_ = 0; }

  bool locked() const { return locked_; }  // numbers are given
  std::int64_t newest() const { return newest_; }
  double period_ns() const { return period_ns_; }
  // Stamp of an exposure by the grid, relative to base_ns() (a double would not hold today's nanoseconds).
  double grid_ns(std::int64_t index) const { return grid_ns_ + static_cast<double>(index - newest_) * period_ns_; }
  TimestampNs base_ns() const { return base_ns_; }
  // Mean of arrival - stamp, relative to base_delay_ns().
  double delay_ns() const { return delay_ns_; }
  std::int64_t base_delay_ns() const { return base_delay_ns_; }

 private:
  static constexpr std::size_t kRecent = 32;

  bool was_here(TimestampNs stamp_ns);
  Reading begin(TimestampNs stamp_ns, std::int64_t arrival_ns, bool restarted);
  Reading learn(std::int64_t step, double residual_ns, double delay_ns, TimestampNs stamp_ns, std::int64_t arrival_ns);
  Reading number(std::int64_t step, double residual_ns, double delay_ns, TimestampNs stamp_ns, std::int64_t arrival_ns);
  void advance(std::int64_t step, double residual_ns);
  void doubt();
  void collect_delay(double late);
  void follow_delay();
  double on_time() const;

  double nominal_ns_;
  double period_ns_;
  TimestampNs base_ns_ = 0;
  std::int64_t base_delay_ns_ = 0;
  double grid_ns_ = 0.0;  // of newest_
  std::int64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit j: number newest_ - j was here
  double delay_ns_ = 0.0;
  double least_delay_ns_ = 0.0;
  double most_delay_ns_ = 0.0;
  int frames_ = 0;  // on the grid so far; 0 = begin
  int irregular_ = 0;
  bool locked_ = false;
  int doubts_ = 0;       // frames on time that it takes until numbers are certain
  int unconfirmed_ = 0;  // frames since the first doubt
  double spread_ = 0.0;  // mean deviation of arrivals, periods
  int collected_ = 0;    // of the frames since the first doubt, those that count for the delay
  double late_sum_ = 0.0;
  double spread_sum_ = 0.0;
  std::array<TimestampNs, kRecent> recent_{};
  std::size_t recent_count_ = 0;
};

}  // namespace cliquevo::drivers
