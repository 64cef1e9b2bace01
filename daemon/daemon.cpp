// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/daemon.h"

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/caught.h"
#include "core/rt/memory.h"
#include "core/rt/thread.h"
#include "daemon/commands.h"
#include "daemon/daemon_work.h"
#include "daemon/first_pairs.h"
#include "daemon/log.h"
#include "daemon/output.h"
#include "daemon/pipeline/effective_config.h"
#include "daemon/recording.h"
#include "daemon/reload.h"
#include "daemon/start_up.h"
#include "daemon/threads/pipeline.h"
#include "daemon/watch.h"
#include "drivers/describe.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kRouteRetryNs = 500'000'000;  // for a route or a server; a try takes as long at most
constexpr std::int64_t kPatienceNs = 5'000'000'000;  // for frames on their way once stopping

void describe(const drivers::SourceInfo& source, const RectifiedSize& size, const StereoModel& model) {
  spdlog::info(drivers::describe_source(source));
  const std::string chosen = describe(size, source);
  if (!chosen.empty()) spdlog::log(size.fits ? spdlog::level::info : spdlog::level::warn, chosen);
  for (const std::string& note : source.calibration.notes) spdlog::warn("calibration: {}", note);
  const std::string lines = drivers::describe_geometry(model);
  std::size_t begin = 0;
  while (begin < lines.size()) {
    const std::size_t end = std::min(lines.find('\n', begin), lines.size());
    spdlog::info(lines.substr(begin, end - begin));
    begin = end + 1;
  }
}

// As a service it is started while the network comes up, and a vehicle may have none until somebody plugs it in: it
// waits for a route, and reports it. Nothing: stopped before there was one.
Result<std::optional<Publisher>> make_publisher(const Config& config, const Signals& signals, Service& service) {
  for (bool first = true;; first = false) {
    auto publisher = Publisher::make(config.lcm, config.T_body_camera);
    if (publisher) return std::optional<Publisher>(std::move(*publisher));
    if (!Service::is_managed()) return publisher.error();
    if (first) {
      report(publisher.error());
      service.status(config.lcm.url.starts_with("tcpq:") ? "waiting for the LCM server"
                                                         : "waiting for a route for LCM messages");
      service.ready();
    }
    service.feed_watchdog();
    const int signal = signals.wait(kRouteRetryNs);
    if (signal == SIGTERM || signal == SIGINT) return std::optional<Publisher>();
  }
}

PipelineOptions pipeline_options(const Config& config) {
  PipelineOptions options;
  options.speed = config.source.speed;
  options.errors_are_final = config.source.type != "recording";  // a torn pair is skipped and counted
  options.stereo.cpu = config.realtime.stereo_cpu;
  options.stereo.fifo_priority = config.realtime.stereo_priority;
  options.odometry.cpu = config.realtime.odometry_cpu;
  options.odometry.fifo_priority = config.realtime.odometry_priority;
  options.output.fifo_priority = config.realtime.output_priority;
  options.catch_up_frames = config.realtime.catch_up_frames;
  return options;
}

int ended_by(const Error& error) {
  report(error);
  return is_caught(error) ? unexpected_end() : kBadInput;
}

// Everything that runs, in the order in which it is built.
class Daemon {
 public:
  Daemon(const DaemonOptions& options, const Config& config, const Signals& signals)
      : options_(options), config_(config), signals_(signals), start_(config_, signals_, service_) {}

  // false: stopped meanwhile.
  Result<bool> build();
  void run();
  int close();

 private:
  Result<bool> open();
  void start_recording();
  Result<void> start_pipeline();
  void reload_config() { reload(options_.config, config_, *output_, *recording_); }

  const DaemonOptions& options_;
  Config config_;
  const Signals& signals_;
  Service service_;
  StartUp start_;
  std::unique_ptr<Rig> rig_;
  std::string description_;
  bool live_ = false;
  std::unique_ptr<Output> output_;
  std::optional<Recording> recording_;
  std::optional<DaemonWork> work_;
  std::optional<Pipeline> pipeline_;  // last: its threads use the others
};

// Source, stages and output; cameras and the network may have to be waited for.
Result<bool> Daemon::open() {
  auto rig = start_.try_once();
  if (!rig) return rig.error();
  if (start_.stop_asked()) return false;
  auto publisher = make_publisher(config_, signals_, service_);
  if (!publisher) return publisher.error();
  if (!*publisher) return false;
  if (!*rig) rig = start_.wait(**publisher);
  if (!rig) return rig.error();
  if (!*rig) return false;
  rig_ = std::move(*rig);
  auto output =
      Output::make(std::move(**publisher), config_, rig_->stereo.model(), rig_->odometry.mask(), options_.trajectory);
  if (!output) return output.error();
  output_ = std::move(*output);
  return true;
}

void Daemon::start_recording() {
  const drivers::SourceInfo& info = rig_->source->info();
  recording_.emplace(config_.recording, info, config_.source.speed <= 0.0 && !info.live);
  if (config_.recording.at_start) {
    // The odometry is what it is for: without a recording it goes on, and VO_HEALTH reports it.
    if (const auto ok = recording_->start(); !ok) report(ok.error());
  }
  output_->publisher.copy_to([this](const std::string& channel, const std::uint8_t* data, std::size_t size) {
    recording_->add(channel, data, size);
  });
}

Result<void> Daemon::start_pipeline() {
  schedule_workers(config_.realtime, rig_->stereo);
  work_.emplace(*rig_, *output_, !config_.lcm.movers_channel.empty());
  auto examined = examine_first_pairs(std::move(rig_->source), [](const std::string& line) { spdlog::warn(line); });
  auto pipeline = Pipeline::start(pipeline_options(config_), *work_, record_pairs(std::move(examined), *recording_));
  if (!pipeline) return pipeline.error();
  pipeline_.emplace(std::move(*pipeline));
  for (const std::string& missing : pipeline_->shortfalls()) spdlog::warn("without real-time rights: {}", missing);
  return {};
}

Result<bool> Daemon::build() {
  set_up_log(config_.log_level);
  if (config_.realtime.lock_memory) {
    const std::string refused = rt::lock_memory();
    if (!refused.empty()) spdlog::warn("without real-time rights: memory is not locked: {}", refused);
  }
  auto opened = open();
  if (!opened || !*opened) return opened;
  const drivers::SourceInfo& info = rig_->source->info();
  description_ = info.description;
  live_ = info.live;
  describe(info, rig_->size, rig_->stereo.model());
  spdlog::info("sending {}, {} and {} to {}", config_.lcm.delta_channel, config_.lcm.pose_channel,
               config_.lcm.status_channel, config_.lcm.url);
  start_recording();
  if (auto ok = start_pipeline(); !ok) return ok.error();
  return true;
}

void Daemon::run() {
  Commands commands(*pipeline_, *recording_);
  commands.listen(config_);
  if (start_.reload_asked()) reload_config();
  watch({*pipeline_, *output_, *recording_, commands, service_, description_}, signals_, [this] { reload_config(); });
}

int Daemon::close() {
  if (!pipeline_->wait_finished(kPatienceNs)) {
    report({"a stage does not end", description_, "the daemon ends without the frames on their way"});
    std::fflush(nullptr);
    std::_Exit(kBadInput);  // its thread cannot be joined
  }
  if (const auto ok = recording_->stop(); !ok) report(ok.error());
  const PipelineCounts counts = pipeline_->counts();
  spdlog::info("{} frames: {} poses sent ({} valid), {} dropped, {} rejected", counts.grabbed, counts.published,
               output_->sent.valid.load(), counts.dropped, counts.rejected);
  if (!live_ && counts.source_errors > 0) spdlog::warn("{} pairs of the recording skipped", counts.source_errors);
  if (const std::string finding = pipeline_->source_finding(); !finding.empty()) spdlog::warn(finding);
  int exit_code = kDone;
  if (output_->trajectory) {
    if (const auto ok = output_->trajectory->close(); !ok) exit_code = (report(ok.error()), kBadInput);
  }
  if (const auto ok = pipeline_->outcome(); !ok) {
    exit_code = ended_by(ok.error());
    if (live_) exit_code = unexpected_end();
  }
  return exit_code;
}

}  // namespace

int unexpected_end() { return Service::is_managed() ? kStartAgain : kBadInput; }

int check(const DaemonOptions& options) {
  const auto config = read_daemon_config(options.config);
  if (!config) return report(config.error()), kBadInput;
  drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
  Config tried = *config;
  tried.rectify.scale =
      config->rectify.scale.value_or(1.0);  // cliquevo doctor measures what this machine keeps up with
  const auto rig = open_rig(tried, ignored);
  if (!rig) return report(rig.error()), kBadInput;
  const std::string source = drivers::describe_source((*rig)->source->info());
  if (options.json) {
    fmt::print("{}\n", effective_config_json(*config, source));
  } else {
    fmt::print("# {}\n{}", source, effective_config_yaml(*config));
  }
  return kDone;
}

int run(const DaemonOptions& options) {
  const Signals signals;
  rt::exceptions_end_with(unexpected_end());
  auto config = read_daemon_config(options.config);
  if (!config) return ended_by(config.error());
  config->source.cameras.patience_s = 0.0;  // it waits itself, and reports for what
  Daemon daemon(options, *config, signals);
  const auto built = daemon.build();
  if (!built) return ended_by(built.error());
  if (!*built) return kDone;
  daemon.run();
  return daemon.close();
}

}  // namespace cliquevo::daemon
