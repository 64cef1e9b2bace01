// SPDX-License-Identifier: BSD-3-Clause
#include "tools/logged_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "daemon/pipeline/lcm_config.h"
#include "drivers/recording/pair_store.h"

namespace cliquevo::tools {

namespace {

constexpr const char* kPointsChannel = "VO_POINTS";  // as the configuration's example has it: it is off by itself
constexpr std::int64_t kMostUs = INT64_MAX / 2000;

template <typename Message>
void take(const drivers::EventLogReader& log, const drivers::LoggedEvent& event, std::vector<Message>& out) {
  Message m{};  // of one size, whatever is in it
  std::vector<std::uint8_t> bytes;
  if (event.size != m.getEncodedSize() || !log.read(event, bytes)) return;
  if (m.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return;
  if (m.utime < 0 || m.utime > kMostUs) return;
  const auto& q = m.orientation;
  const double norm = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (std::isfinite(norm) && norm > 0.5) out.push_back(m);
}

template <typename Message>
void sort_by_time(std::vector<Message>& messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const auto& a, const auto& b) { return a.utime < b.utime; });
}

}  // namespace

std::optional<points_t> LoggedPoints::read(std::size_t i) const {
  const Place& place = places_[i];
  std::vector<std::uint8_t> bytes;
  points_t m{};
  if (!logs_[place.log].read(place.event, bytes)) return std::nullopt;
  if (m.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return std::nullopt;
  if (m.utime < 0 || m.utime > kMostUs) return std::nullopt;
  return m;
}

LoggedPoses read_logged_poses(const std::string& path) {
  const daemon::LcmConfig names;
  LoggedPoses out;
  for (const std::string& file : drivers::find_logs(path)) {
    auto log = drivers::EventLogReader::open(file);
    if (!log) continue;
    log->scan([&](std::string_view channel, const drivers::LoggedEvent& event) {
      if (channel == names.odometry_channel) take(*log, event, out.odometry);
      if (channel == names.pose_channel) take(*log, event, out.poses);
      if (channel == kPointsChannel) out.points.places_.push_back({out.points.logs_.size(), event});
    });
    out.points.logs_.push_back(std::move(*log));
  }
  if (!out.odometry.empty()) out.poses.clear();
  sort_by_time(out.odometry);
  sort_by_time(out.poses);
  std::stable_sort(out.points.places_.begin(), out.points.places_.end(),
                   [](const auto& a, const auto& b) { return a.event.utime < b.event.utime; });
  return out;
}

}  // namespace cliquevo::tools
