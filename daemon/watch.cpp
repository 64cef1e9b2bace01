// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/watch.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/caught.h"
#include "core/base/time.h"
#include "daemon/health.h"
#include "daemon/log.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kWatchdogTickNs = 100'000'000;  // how often the watchdog is fed
constexpr std::int64_t kReportNs = 1'000'000'000;

// What the user should know of the rig, once each.
class OneTimeWarnings {
 public:
  void give(const LatestDiagnostics& diagnostics, const std::string& source_finding) {
    const auto [calibration, vehicle_part] = diagnostics.read();
    if (!source_finding.empty()) {
      if (!std::exchange(source_given_, true)) spdlog::warn(source_finding);
      return;  // what else the images seem to say rests on it
    }
    if (calibration.noticeable() && !std::exchange(calibration_given_, true)) spdlog::warn(vo::describe(calibration));
    if (vehicle_part.frames > 0 && !std::exchange(view_given_, true)) spdlog::warn(vo::describe(vehicle_part));
  }

 private:
  bool calibration_given_ = false;
  bool view_given_ = false;
  bool source_given_ = false;
};

// A change of state, with what was found then, for whoever searches the journal.
void log_state(const health_t& now, std::int8_t& last_state) {
  if (std::exchange(last_state, now.state) == now.state) return;
  log_fields(now.state_text, {{"STATE", now.state_text},
                              {"POSE_RATE_HZ", std::to_string(now.pose_rate_hz)},
                              {"LATENCY_P99_US", std::to_string(now.latency_p99_us)},
                              {"FRAMES_GRABBED", std::to_string(now.frames_grabbed)},
                              {"FRAMES_DROPPED", std::to_string(now.frames_dropped)}});
}

void report_health(const Watched& watched, Health& health, OneTimeWarnings& warnings, std::int8_t& last_state) {
  const health_t& message =
      health.update(monotonic_ns(), watched.recording.status(), watched.commands.incidents().text());
  watched.output.publisher.publish(message);
  watched.commands.set_status(message);
  warnings.give(watched.output.diagnostics, watched.pipeline.source_finding());
  watched.service.status(health.status_text());
  log_state(message, last_state);
  spdlog::debug(health.status_text());
}

}  // namespace

void watch(const Watched& watched, const Signals& signals, const std::function<void()>& on_hangup) {
  Health health(watched.pipeline, watched.output.sent, watched.output.diagnostics, watched.source);
  OneTimeWarnings warnings;
  std::int8_t last_state = -1;
  Service& service = watched.service;
  std::int64_t next_report_ns = monotonic_ns() + kReportNs;
  const auto unharmed = [&watched](const auto& work) {  // a report that fails is no reason to end
    const auto done = guarded("cliquevod", [&] { return work(), Result<void>(); });
    if (!done) watched.commands.incidents().add(done.error().line());
  };
  while (!watched.pipeline.wait_finished(0)) {
    const int signal = signals.wait(kWatchdogTickNs);
    if (signal == SIGTERM || signal == SIGINT) {
      spdlog::info("stopping on signal {}", signal);
      break;
    }
    if (signal == SIGHUP) {
      service.reloading();
      unharmed(on_hangup);
      service.reloaded();
    }
    if (health.may_feed_watchdog()) service.feed_watchdog();
    const std::int64_t now_ns = monotonic_ns();
    if (now_ns >= next_report_ns) {
      next_report_ns += kReportNs * (1 + (now_ns - next_report_ns) / kReportNs);
      unharmed([&] { report_health(watched, health, warnings, last_state); });
    }
    if (health.ready()) service.ready();
  }
  service.stopping();
  watched.pipeline.stop();
}

}  // namespace cliquevo::daemon
