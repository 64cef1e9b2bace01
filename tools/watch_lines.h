// SPDX-License-Identifier: BSD-3-Clause
// What `cliquevo watch` shows, put together from a daemon's messages.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include <cliquevo/health_t.hpp>
#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>

#include "core/base/time.h"

namespace cliquevo::tools {

class WatchedDaemon {
 public:
  void take(const status_t& status, TimestampNs now_mono_ns);
  void take(const pose_t& pose, TimestampNs now_mono_ns);
  void take(const health_t& health, TimestampNs now_mono_ns);

  // Several lines, each with its end.
  std::string lines(TimestampNs now_mono_ns) const;
  // The same in one line.
  std::string line(TimestampNs now_mono_ns) const;

 private:
  struct Frame {
    TimestampNs at_ns = 0;
    int status = 0;
    std::int64_t latency_us = 0;
  };
  void seen(TimestampNs now_mono_ns) { last_ns_ = now_mono_ns; }
  std::string state(TimestampNs now_mono_ns) const;
  std::string verdicts() const;
  double latency_ms() const;  // median of the last frames

  std::deque<Frame> frames_;  // of the last seconds
  std::optional<status_t> status_;
  std::optional<pose_t> pose_;
  std::optional<health_t> health_;
  TimestampNs last_ns_ = 0;
};

}  // namespace cliquevo::tools
