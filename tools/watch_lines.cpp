// SPDX-License-Identifier: BSD-3-Clause
#include "tools/watch_lines.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "core/vo/evidence.h"
#include "core/vo/verdict.h"

namespace cliquevo::tools {

namespace {

constexpr TimestampNs kWindowNs = 10'000'000'000;
constexpr TimestampNs kSilentNs = 3'000'000'000;
constexpr std::size_t kMostFrames = 10'000;

// Which checks failed, by their names.
std::string failed_checks(std::int32_t mask) {
  std::string out;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    if ((static_cast<std::uint32_t>(mask) >> k & 1U) == 0) continue;
    out += (out.empty() ? "" : ", ") + std::string(vo::check_name(static_cast<vo::Check>(k)));
  }
  return out;
}

}  // namespace

void WatchedDaemon::take(const status_t& status, TimestampNs now_mono_ns) {
  seen(now_mono_ns);
  status_ = status;
  const std::int64_t latency_us = status.grabbed_utime > 0 ? status.publish_utime - status.grabbed_utime : 0;
  frames_.push_back({now_mono_ns, status.status, latency_us});
  while (frames_.size() > kMostFrames || frames_.front().at_ns < now_mono_ns - kWindowNs) frames_.pop_front();
}

void WatchedDaemon::take(const pose_t& pose, TimestampNs now_mono_ns) {
  seen(now_mono_ns);
  pose_ = pose;
}

void WatchedDaemon::take(const health_t& health, TimestampNs now_mono_ns) {
  seen(now_mono_ns);
  health_ = health;
}

std::string WatchedDaemon::state(TimestampNs now_mono_ns) const {
  if (last_ns_ == 0) return "no messages yet";
  if (now_mono_ns - last_ns_ > kSilentNs) {
    return fmt::format("silent for {:.0f} s", static_cast<double>(now_mono_ns - last_ns_) * 1e-9);
  }
  if (!health_) return "sending";
  return fmt::format("{}, up {:.0f} s", printable(health_->state_text), health_->uptime_s);
}

std::string WatchedDaemon::verdicts() const {
  std::map<int, std::size_t> counts;
  for (const Frame& frame : frames_) ++counts[frame.status];
  std::string out;
  for (const auto& [status, count] : counts) {
    out += fmt::format("{}{} {}", out.empty() ? "" : ", ", count, vo::status_name(static_cast<vo::Status>(status)));
  }
  if (out.empty()) return "none";
  if (status_ && status_->checks_failed != 0) {
    out += fmt::format("; last failed: {}", failed_checks(status_->checks_failed));
  }
  return out;
}

double WatchedDaemon::latency_ms() const {
  std::vector<std::int64_t> sorted;
  for (const Frame& frame : frames_) sorted.push_back(frame.latency_us);
  if (sorted.empty()) return 0.0;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return 1e-3 * static_cast<double>(*middle);
}

std::string WatchedDaemon::lines(TimestampNs now_mono_ns) const {
  std::string out = fmt::format("{:<12}{}\n", "state", state(now_mono_ns));
  if (health_) {
    out += fmt::format("{:<12}{:.1f} Hz in, {:.1f} Hz out, {:.0f} % valid, {} dropped\n", "rate", health_->grab_rate_hz,
                       health_->pose_rate_hz, 100.0 * health_->valid_share, health_->frames_dropped);
    out += fmt::format("{:<12}median {:.1f} ms, 99 % {:.1f} ms\n", "latency", 1e-3 * health_->latency_p50_us,
                       1e-3 * health_->latency_p99_us);
  } else if (!frames_.empty()) {
    out += fmt::format("{:<12}median {:.1f} ms\n", "latency", latency_ms());
  }
  out += fmt::format("{:<12}{} (last 10 s)\n", "verdicts", verdicts());
  if (pose_) {
    out += fmt::format("{:<12}{:.3f} {:.3f} {:.3f} m, {:.2f} m/s\n", "pose", pose_->pos[0], pose_->pos[1],
                       pose_->pos[2], std::hypot(pose_->vel[0], pose_->vel[1], pose_->vel[2]));
  }
  if (status_) out += fmt::format("{:<12}{} of 100\n", "quality", status_->quality);
  if (!health_) return out;
  for (const auto& [name, text] :
       {std::pair{"calibration", &health_->calibration_text}, std::pair{"view", &health_->view_text},
        std::pair{"source", &health_->source_text}, std::pair{"recording", &health_->recording_text},
        std::pair{"incidents", &health_->incident_text}}) {
    if (!text->empty()) out += fmt::format("{:<12}{}\n", name, printable(*text));
  }
  return out;
}

std::string WatchedDaemon::line(TimestampNs now_mono_ns) const {
  std::string out = state(now_mono_ns);
  if (health_) out += fmt::format("; {:.1f} Hz, {:.1f} ms", health_->pose_rate_hz, 1e-3 * health_->latency_p50_us);
  return out + "; " + verdicts() + "\n";
}

}  // namespace cliquevo::tools
