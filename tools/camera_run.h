// SPDX-License-Identifier: BSD-3-Clause
// What the compliance run of a rig looks at: the pairs of one streaming period, and the verdict on them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace cliquevo::tools {

// Of one streaming period.
class CameraRun {
 public:
  explicit CameraRun(double rate_hz) : period_ns_(1e9 / rate_hz) {}

  void add(TimestampNs stamp_ns, std::int64_t right_offset_ns, std::int64_t delay_ns);
  std::int64_t pairs() const { return static_cast<std::int64_t>(stamps_ns_.size()); }

  struct Verdict {
    double rate_hz = 0.0;                 // without what was skipped
    std::int64_t skipped = 0;             // exposures between the first and the last pair that gave none
    double most_jitter = 0.0;             // |dt - period|, periods, skips left out
    double most_skew = 0.0;               // between the cameras, periods
    double most_delay_ms = 0.0;           // exposure to arrival
    std::vector<std::string> complaints;  // empty: passed
  };
  Verdict judge() const;
  // |dt - period| and the skew, as lines of text.
  std::string histograms() const;

 private:
  double period_ns_;
  std::vector<TimestampNs> stamps_ns_;
  std::vector<double> skews_;  // periods
  std::vector<double> delays_ms_;
};

}  // namespace cliquevo::tools
