// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/base/clock.h"
#include "core/base/printable.h"
#include "daemon/lcm/messages.h"
#include "daemon/machine.h"

namespace cliquevo::daemon {

namespace {

// Without a frame for this long the source counts as silent.
constexpr std::int64_t kSilentNs = 2'000'000'000;

std::int32_t to_us(std::int64_t ns) {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(ns / 1000, 0, std::numeric_limits<std::int32_t>::max()));
}

double rate(std::int64_t count, std::int64_t span_ns) {
  return span_ns > 0 ? static_cast<double>(count) * 1e9 / static_cast<double>(span_ns) : 0.0;
}

}  // namespace

Health::Health(const Pipeline& pipeline, const SentCounts& sent, const LatestDiagnostics& diagnostics,
               const std::string& source_description)
    : pipeline_(pipeline),
      sent_(sent),
      diagnostics_(diagnostics),
      source_(printable(source_description)),
      start_ns_(monotonic_ns()),
      last_update_ns_(start_ns_),
      last_frame_ns_(start_ns_),
      last_histograms_(kSpans) {}

bool Health::may_feed_watchdog() const {
  for (const StageId stage : {StageId::stereo, StageId::odometry, StageId::output}) {
    if (pipeline_.standing_still_ns(stage) > kStillNs) return false;
  }
  return true;
}

bool Health::ready() const {
  return pipeline_.counts().published > 0 || message_.state == health_t::WAITING_FOR_FRAMES;
}

void Health::judge(std::int64_t grabbed_now, std::int64_t sent_now) {
  const std::int64_t silent_ns = last_update_ns_ - last_frame_ns_;
  for (const StageId stage : {StageId::stereo, StageId::odometry, StageId::output}) {
    if (pipeline_.standing_still_ns(stage) <= kStillNs) continue;
    message_.state = health_t::STALLED;
    message_.state_text = fmt::format("stalled: the {} stage does not get on", stage_name(stage));
    return;
  }
  if (sent_now > 0 || grabbed_now > 0) {
    message_.state = health_t::RUNNING;
    message_.state_text = "running";
  } else if (silent_ns > kSilentNs) {
    message_.state = health_t::WAITING_FOR_FRAMES;
    message_.state_text =
        fmt::format("waiting for frames for {:.0f} s from {}", static_cast<double>(silent_ns) * 1e-9, source_);
  }
}

void Health::fill_latencies(health_t& out) {
  out.stage_name.clear();
  out.stage_p50_us.clear();
  out.stage_p99_us.clear();
  for (int i = 0; i < kSpans; ++i) {
    const auto span = static_cast<Span>(i);
    const rt::Histogram::Counts now = pipeline_.histogram(span).counts();
    rt::Histogram::Counts& before = last_histograms_[static_cast<std::size_t>(i)];
    const rt::Percentiles second = rt::Histogram::percentiles_of(rt::Histogram::difference(now, before));
    if (span == Span::total) {
      out.latency_p50_us = to_us(second.p50_ns);
      out.latency_p99_us = to_us(second.p99_ns);
      out.latency_max_us = to_us(second.max_ns);
      out.latency_p999_us = to_us(rt::Histogram::percentile_of(now, 0.999));
    } else {
      out.stage_name.emplace_back(span_name(span));
      out.stage_p50_us.push_back(to_us(second.p50_ns));
      out.stage_p99_us.push_back(to_us(second.p99_ns));
    }
    before = now;
  }
  out.num_stages = static_cast<std::int32_t>(out.stage_name.size());
}

void Health::fill_diagnostics(health_t& out) const {
  const auto [calibration, vehicle_part] = diagnostics_.read();
  // What the calibration seems to be off by means nothing then.
  const std::string finding = pipeline_.source_finding();
  out.calibration_text = finding.empty() ? vo::describe(calibration) : "not checked: " + finding;
  out.view_text = vo::describe(vehicle_part);
  const bool known = calibration.frames > 0 && finding.empty();
  for (int i = 0; i < 3; ++i) {
    out.right_eye_deg[i] = known ? calibration.rotation_deg[i] : 0.0;
    out.right_eye_sigma_deg[i] = known ? calibration.rotation_sigma_deg[i] : 0.0;
  }
}

const health_t& Health::update(std::int64_t now_mono_ns, const std::string& recording, const std::string& incidents) {
  const PipelineCounts counts = pipeline_.counts();
  const std::int64_t valid = sent_.valid.load(std::memory_order_relaxed);
  const std::int64_t span_ns = now_mono_ns - last_update_ns_;
  const std::int64_t grabbed_now = counts.grabbed - last_counts_.grabbed;
  const std::int64_t sent_now = counts.published - last_counts_.published;
  last_update_ns_ = now_mono_ns;
  if (grabbed_now > 0) last_frame_ns_ = now_mono_ns;

  health_t& out = message_;
  judge(grabbed_now, sent_now);
  out.source_text = printable(pipeline_.source_status());
  out.recording_text = recording;
  out.incident_text = printable(incidents);
  out.utime = floor_us(utc_now_ns());
  out.uptime_s = static_cast<double>(now_mono_ns - start_ns_) * 1e-9;
  out.grab_rate_hz = rate(grabbed_now, span_ns);
  out.pose_rate_hz = rate(sent_now, span_ns);
  // The two counters are read one after the other: never above 1.
  out.valid_share =
      sent_now > 0 ? std::min(1.0, static_cast<double>(valid - last_valid_) / static_cast<double>(sent_now)) : 0.0;
  out.frames_grabbed = counts.grabbed;
  out.poses_sent = counts.published;
  out.frames_dropped = counts.dropped;
  out.frames_rejected = counts.rejected;
  out.source_errors = counts.source_errors;
  out.send_errors = sent_.send_errors.load(std::memory_order_relaxed) + counts.unsent;
  out.resets = counts.resets;
  fill_latencies(out);
  fill_diagnostics(out);
  out.resident_bytes = resident_bytes();
  out.temperature_name.clear();
  out.temperature_c.clear();
  for (const auto& [name, celsius] : temperatures()) {
    out.temperature_name.push_back(name);
    out.temperature_c.push_back(celsius);
  }
  out.num_temperatures = static_cast<std::int32_t>(out.temperature_c.size());

  last_counts_ = counts;
  last_valid_ = valid;
  status_text_ =
      fmt::format("{}; {:.1f} Hz, latency {:.1f} ms (p99 {:.1f} ms), {:.0f} % valid, {} dropped",
                  out.state_text.empty() ? "starting" : out.state_text, out.pose_rate_hz, out.latency_p50_us * 1e-3,
                  out.latency_p99_us * 1e-3, 100.0 * out.valid_share, counts.dropped);
  for (const std::string* text : {&out.source_text, &out.recording_text, &out.incident_text}) {
    if (!text->empty()) status_text_ += "; " + *text;
  }
  return out;
}

}  // namespace cliquevo::daemon
