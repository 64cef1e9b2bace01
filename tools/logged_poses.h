// SPDX-License-Identifier: BSD-3-Clause
// The odometry that a log holds beside its pairs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/pose_t.hpp>

#include "drivers/recording/event_log.h"

namespace cliquevo::tools {

// VO_POINTS: large, so their places alone are kept.
class LoggedPoints {
 public:
  std::size_t size() const { return places_.size(); }
  // The log's time of the event, us; rises.
  std::int64_t utime(std::size_t i) const { return places_[i].event.utime; }
  // None: it cannot be read, or is no such message.
  std::optional<points_t> read(std::size_t i) const;

 private:
  friend struct LoggedPoses read_logged_poses(const std::string& path);
  struct Place {
    std::size_t log = 0;
    drivers::LoggedEvent event;
  };
  std::vector<drivers::EventLogReader> logs_;
  std::vector<Place> places_;
};

struct LoggedPoses {
  std::vector<odometry_t> odometry;  // VO_ODOMETRY
  std::vector<pose_t> poses;         // POSE_BODY, of logs that have no VO_ODOMETRY
  LoggedPoints points;
};

// Of a log or a folder of such, by their exposure; nothing for any other source.
LoggedPoses read_logged_poses(const std::string& path);

}  // namespace cliquevo::tools
