// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/metrics.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cliquevo::view {

namespace {

using nlohmann::json;

struct Metric {
  const char* member;  // of the health message
  const char* name;
  const char* type;
  double per_unit;  // the member, divided by this
  const char* help;
};
constexpr Metric kMetrics[] = {
    {"uptime_s", "uptime_seconds", "gauge", 1.0, "Time since the daemon's start."},
    {"grab_rate_hz", "grab_rate_hertz", "gauge", 1.0, "Frames from the source, over the last second."},
    {"pose_rate_hz", "pose_rate_hertz", "gauge", 1.0, "Poses sent, over the last second."},
    {"valid_share", "valid_ratio", "gauge", 1.0, "Share of the last second's poses that rest on a valid motion."},
    {"frames_grabbed", "frames_grabbed_total", "counter", 1.0, "Frames from the source."},
    {"poses_sent", "poses_sent_total", "counter", 1.0, "Poses sent."},
    {"frames_dropped", "frames_dropped_total", "counter", 1.0, "Frames skipped because a newer one was there."},
    {"frames_rejected", "frames_rejected_total", "counter", 1.0, "Frames that could not be used."},
    {"source_errors", "source_errors_total", "counter", 1.0, "Errors of the camera or recording."},
    {"send_errors", "send_errors_total", "counter", 1.0, "Messages that LCM did not take."},
    {"resets", "resets_total", "counter", 1.0, "Resets of the pose to the origin."},
    {"latency_p50_us", "latency_median_seconds", "gauge", 1e6, "From frame to pose over the last second: median."},
    {"latency_p99_us", "latency_p99_seconds", "gauge", 1e6, "From frame to pose over the last second: 99 %."},
    {"latency_max_us", "latency_max_seconds", "gauge", 1e6, "From frame to pose over the last second: the longest."},
    {"resident_bytes", "resident_memory_bytes", "gauge", 1.0, "Memory in use."},
};

std::string one(const char* name, const char* type, const char* help, const std::string& value) {
  return fmt::format("# HELP cliquevo_{0} {1}\n# TYPE cliquevo_{0} {2}\ncliquevo_{0}{3}\n", name, help, type, value);
}

}  // namespace

std::string metrics_text(const FeedState& state, const std::string& version) {
  std::string out =
      one("view_info", "gauge", "The view that serves this.", fmt::format("{{version=\"{}\"}} 1", version));
  const json health = json::parse(state.health_json, nullptr, false);
  const bool up = health.is_object() && state.text == "live";
  out += one("up", "gauge", "1 while the daemon sends.", up ? " 1" : " 0");
  if (!up) return out;  // the last figures are out of date
  const auto named = health.find("state");
  const std::string current = named != health.end() && named->is_string() ? named->get<std::string>() : "";
  std::string states;
  for (const char* name : {"starting", "running", "waiting", "stalled"}) {
    states +=
        fmt::format("{}{{state=\"{}\"}} {}", states.empty() ? "" : "\ncliquevo_state", name, current == name ? 1 : 0);
  }
  out += one("state", "gauge", "1 for the state that the daemon is in.", states);
  for (const Metric& metric : kMetrics) {
    const auto value = health.find(metric.member);
    if (value == health.end() || !value->is_number()) continue;
    out += one(metric.name, metric.type, metric.help, fmt::format(" {}", value->get<double>() / metric.per_unit));
  }
  return out;
}

}  // namespace cliquevo::view
