// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/start_up.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "daemon/lcm/messages.h"
#include "daemon/pipeline/source.h"

namespace cliquevo::daemon {

namespace {

using drivers::OpenTrouble;

constexpr std::int64_t kTickNs = 20'000'000;
constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kFirstPauseNs = 200'000'000;
constexpr std::int64_t kLastPauseNs = 2 * kSecondNs;
constexpr std::int64_t kMostTryNs = 120 * kSecondNs;  // a try that takes longer hangs: the watchdog is not fed
constexpr std::int64_t kMostStopNs = 1 * kSecondNs;   // for a try that is under way when the daemon is to stop

// A try on a thread of its own.
struct Try {
  Result<std::unique_ptr<Rig>> rig{std::unique_ptr<Rig>()};
  OpenTrouble trouble = OpenTrouble::lasting;
  std::atomic<bool> done{false};
};

void run(const Config& config, Try& into) {
  try {
    into.rig = open_rig(config, into.trouble);
  } catch (...) {  // out of memory, a library at its end
    into.rig = caught("source.type = " + config.source.type);
    into.trouble = OpenTrouble::lasting;
  }
  into.done.store(true, std::memory_order_release);
}

}  // namespace

Result<std::unique_ptr<Rig>> open_rig(const Config& config, OpenTrouble& trouble) {
  auto source = open_source(config.source, trouble);
  if (!source) return source.error();
  trouble = OpenTrouble::lasting;
  const drivers::SourceInfo& info = (*source)->info();
  const auto size = choose_rectified_size(config, info);
  if (!size) return size.error();
  stereo::RectifyParams rectify = config.rectify;
  rectify.scale = size->scale;
  auto stereo = StereoStage::make(config.stereo, info, rectify);
  if (!stereo) return stereo.error();
  auto odometry = OdometryStage::make(config.odometry, info, *stereo);
  if (!odometry) return odometry.error();
  return std::make_unique<Rig>(Rig{std::move(*source), *size, std::move(*stereo), std::move(*odometry)});
}

health_t waiting_health(std::int64_t start_mono_ns, const std::string& waiting_for) {
  health_t out{};
  out.utime = floor_us(utc_now_ns());
  out.state = health_t::WAITING_FOR_FRAMES;
  out.state_text = waiting_for;
  out.source_text = waiting_for;
  out.uptime_s = static_cast<double>(monotonic_ns() - start_mono_ns) * 1e-9;
  out.calibration_text = vo::describe(vo::CalibrationCheck{});
  return out;
}

StartUp::StartUp(const Config& config, const Signals& signals, Service& service)
    : config_(config), signals_(signals), service_(service), start_ns_(monotonic_ns()) {}

// false: a stop was requested.
bool StartUp::tick(std::int64_t pause_ns) {
  const int signal = signals_.wait(std::min(pause_ns, kTickNs));
  if (signal == SIGTERM || signal == SIGINT) {
    spdlog::info("stopping on signal {}", signal);
    stop_asked_ = true;
    service_.stopping();
  }
  reload_asked_ = reload_asked_ || signal == SIGHUP;
  const std::int64_t now_ns = monotonic_ns();
  if (publisher_ != nullptr && !waiting_for_.empty() && now_ns >= next_health_ns_) {
    next_health_ns_ = now_ns + kSecondNs;
    publisher_->publish(waiting_health(start_ns_, waiting_for_));
  }
  return !stop_asked_;
}

void StartUp::report(const Error& error) {
  const std::string state = error.what + ": " + error.where;
  waiting_for_ = fmt::format("waiting for a camera: {}", error.line());
  std::replace(waiting_for_.begin(), waiting_for_.end(), '\n', ' ');
  if (state != std::exchange(logged_, state)) spdlog::warn(waiting_for_);
  service_.status(waiting_for_);
  service_.ready();  // for systemd: it waits for something and says for what
}

Result<std::unique_ptr<Rig>> StartUp::try_once() {
  const auto attempt = std::make_shared<Try>();
  std::thread thread([attempt, config = &config_] { run(*config, *attempt); });
  const std::int64_t begin_ns = monotonic_ns();
  std::int64_t stop_ns = 0;
  while (!attempt->done.load(std::memory_order_acquire)) {
    if (!tick(kTickNs) && stop_ns == 0) stop_ns = monotonic_ns();
    const std::int64_t now_ns = monotonic_ns();
    if (now_ns - begin_ns < kMostTryNs) service_.feed_watchdog();
    if (stop_ns != 0 && now_ns - stop_ns > kMostStopNs) {
      std::fflush(nullptr);
      std::_Exit(0);  // its thread cannot be joined; whatever it holds, the system releases
    }
  }
  thread.join();
  if (stop_asked_) return std::unique_ptr<Rig>();
  if (attempt->rig || attempt->trouble == OpenTrouble::lasting) {
    if (attempt->rig && !waiting_for_.empty()) spdlog::info("what was waited for is there");
    return std::move(attempt->rig);
  }
  report(attempt->rig.error());
  return std::unique_ptr<Rig>();
}

Result<std::unique_ptr<Rig>> StartUp::wait(Publisher& publisher) {
  publisher_ = &publisher;
  std::int64_t pause_ns = kFirstPauseNs;
  for (;;) {
    const std::int64_t until_ns = monotonic_ns() + pause_ns;
    for (std::int64_t left_ns = pause_ns; left_ns > 0; left_ns = until_ns - monotonic_ns()) {
      if (!tick(left_ns)) return std::unique_ptr<Rig>();
      service_.feed_watchdog();
    }
    auto rig = try_once();
    if (!rig || *rig || stop_asked_) return rig;
    pause_ns = std::min(2 * pause_ns, kLastPauseNs);
  }
}

}  // namespace cliquevo::daemon
