// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/daemon.h"

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/caught.h"
#include "core/rt/memory.h"
#include "core/rt/thread.h"
#include "daemon/commands.h"
#include "daemon/config.h"
#include "daemon/effective_config.h"
#include "daemon/first_pairs.h"
#include "daemon/health.h"
#include "daemon/log.h"
#include "daemon/pipeline.h"
#include "daemon/publisher.h"
#include "daemon/recording.h"
#include "daemon/service.h"
#include "daemon/signals.h"
#include "daemon/stages.h"
#include "daemon/start_up.h"
#include "daemon/trajectory_sink.h"
#include "drivers/describe.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kTickNs = 100'000'000;        // how often the watchdog is fed
constexpr std::int64_t kSecondNs = 1'000'000'000;    // health
constexpr std::int64_t kRetryNs = kSecondNs / 2;     // for a route or a server; asking itself takes as long at most
constexpr std::int64_t kPatienceNs = 5 * kSecondNs;  // for frames on their way once stopping

Result<Config> load(const DaemonOptions& options) {
  return options.config.empty() ? Result<Config>(default_config()) : read_config(options.config);
}

// The stereo thread's helpers wait for each other: all of them run like it.
void schedule_workers(const RealtimeConfig& config, StereoStage& stereo) {
  int number = 1;
  for (const auto handle : stereo.worker_handles()) {
    const int cpu = config.worker_cpu >= 0 ? config.worker_cpu + number - 1 : -1;
    ++number;
    const std::string name = fmt::format("vo-stereo-{}", number);
    const std::string missing =
        rt::schedule(handle, {.name = name, .cpu = cpu, .fifo_priority = config.stereo_priority});
    if (!missing.empty()) spdlog::warn("without real-time rights: {}: {}", name, missing);
  }
}

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

// What becomes of each estimate; runs on the output thread.
struct Output {
  Publisher publisher;
  ImageTap tap;
  std::optional<TrajectorySink> trajectory;
  SentCounts sent;
  Findings findings;

  void operator()(const PublishedFrame& frame) {
    bool taken = publisher.publish(frame);
    if (const TappedImages* images = tap.take()) {  // after the pose: nobody steers by a picture
      taken = publisher.publish(*images) && taken;
      tap.give_back();
    }
    if (!taken && sent.send_errors.fetch_add(1, std::memory_order_relaxed) == 0) {
      spdlog::warn("LCM does not take messages: further ones are only counted");
    }
    findings.take(frame.estimate);
    if (frame.estimate.status == vo::Status::valid) sent.valid.fetch_add(1, std::memory_order_relaxed);
    if (trajectory) trajectory->append(frame.estimate.stamp_ns, frame.estimate.T_world_camera);
  }
};

// As a service it is started while the network comes up, and a vehicle may have none until somebody plugs it in: it
// waits for a route, and says so. Nothing: asked to stop before there was one.
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
    const int signal = signals.wait(kRetryNs);
    if (signal == SIGTERM || signal == SIGINT) return std::optional<Publisher>();
  }
}

// SIGHUP: what can change while running does, what cannot is named.
void reload(const DaemonOptions& options, Config& in_force, Output& output, Recording& recording) {
  const auto config = load(options);
  if (!config) return report(config.error());
  if (const auto ok = config->check(); !ok) return report(ok.error());
  const auto old_keys = list_config(in_force);
  const auto new_keys = list_config(*config);
  for (std::size_t i = 0; i < new_keys.size(); ++i) {
    const auto& [key, value] = new_keys[i];
    if (value == old_keys[i].second) continue;
    if (key == "log.level") {
      set_up_log(config->log_level);
      spdlog::info("reloaded: {} is now {}", key, value);
    } else if (key == "lcm.images_rate_hz") {
      output.tap.set_rate(config->lcm.images_rate_hz);
      spdlog::info("reloaded: {} is now {}", key, value);
    } else if (key.starts_with("recording.") && key != "recording.at_start") {
      recording.configure(config->recording);
      spdlog::info("reloaded: {} is now {}, from the next recording on", key, value);
    } else {
      spdlog::warn("reloaded: {} = {} takes effect at the next start", key, value);
    }
  }
  in_force.log_level = config->log_level;
  in_force.lcm.images_rate_hz = config->lcm.images_rate_hz;
  const bool at_start = in_force.recording.at_start;
  in_force.recording = config->recording;
  in_force.recording.at_start = at_start;
  spdlog::info("configuration read again");
}

// What the user should know of the rig, once each.
class Advice {
 public:
  void give(const Findings& findings, const std::string& source_finding) {
    const auto [calibration, vehicle_part] = findings.read();
    if (!source_finding.empty()) {
      if (!std::exchange(source_told_, true)) spdlog::warn(source_finding);
      return;  // what else the images seem to say rests on it
    }
    if (calibration.noticeable() && !std::exchange(calibration_told_, true)) spdlog::warn(vo::describe(calibration));
    if (vehicle_part.frames > 0 && !std::exchange(view_told_, true)) spdlog::warn(vo::describe(vehicle_part));
  }

 private:
  bool calibration_told_ = false;
  bool view_told_ = false;
  bool source_told_ = false;
};

// Once a second.
void tell(Health& health, const Pipeline& pipeline, Output& output, Recording& recording, Commands& commands,
          Advice& advice, Service& service) {
  const health_t& message = health.update(monotonic_ns(), recording.status(), commands.incidents().text());
  output.publisher.publish(message);
  commands.set_status(message);
  advice.give(output.findings, pipeline.source_finding());
  service.status(health.status_text());
  spdlog::debug(health.status_text());
}

// Feeds the watchdog, reports, and waits for the end of the source or a signal to stop.
void watch(Pipeline& pipeline, Output& output, Recording& recording, Commands& commands, const Signals& signals,
           Service& service, const std::string& source, const std::function<void()>& on_hangup) {
  Health health(pipeline, output.sent, output.findings, source);
  Advice advice;
  std::int64_t next_report_ns = monotonic_ns() + kSecondNs;
  const auto unharmed = [&commands](const auto& work) {  // a report that fails is no reason to end
    const auto done = guarded("cliquevod", [&] { return work(), Result<void>(); });
    if (!done) commands.incidents().add(done.error().line());
  };
  while (!pipeline.wait_finished(0)) {
    const int signal = signals.wait(kTickNs);
    if (signal == SIGTERM || signal == SIGINT) {
      spdlog::info("stopping: asked to by signal {}", signal);
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
      next_report_ns += kSecondNs * (1 + (now_ns - next_report_ns) / kSecondNs);
      unharmed([&] { tell(health, pipeline, output, recording, commands, advice, service); });
    }
    if (health.ready()) service.ready();
  }
  service.stopping();
  pipeline.stop();
}

}  // namespace

int unexpected_end() { return Service::is_managed() ? kStartAgain : kBadInput; }

namespace {

int ended_by(const Error& error) {
  report(error);
  return is_caught(error) ? unexpected_end() : kBadInput;
}

}  // namespace

int check(const DaemonOptions& options) {
  const auto config = load(options);
  if (!config) return report(config.error()), kBadInput;
  if (const auto ok = config->check(); !ok) return report(ok.error()), kBadInput;
  drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
  Config tried = *config;
  tried.rectify.scale = config->rectify.scale.value_or(1.0);  // what this machine keeps up with is the doctor's to say
  const auto rig = open_rig(tried, ignored);
  if (!rig) return report(rig.error()), kBadInput;
  fmt::print("# {}\n", drivers::describe_source((*rig)->source->info()));
  fmt::print("{}", effective_config_yaml(*config));
  return kDone;
}

int run(const DaemonOptions& options) {
  const Signals signals;
  Service service;
  rt::exceptions_end_with(unexpected_end());
  auto config = load(options);
  if (!config) return ended_by(config.error());
  if (const auto ok = config->check(); !ok) return ended_by(ok.error());
  set_up_log(config->log_level);
  if (config->realtime.lock_memory) {
    const std::string refused = rt::lock_memory();
    if (!refused.empty()) spdlog::warn("without real-time rights: memory is not locked: {}", refused);
  }

  config->source.cameras.patience_s = 0.0;  // it waits itself, and says for what
  StartUp start(*config, signals, service);
  auto rig = start.try_once();
  if (!rig) return ended_by(rig.error());
  if (start.stop_asked()) return kDone;
  auto publisher = make_publisher(*config, signals, service);
  if (!publisher) return ended_by(publisher.error());
  if (!*publisher) return kDone;
  if (!*rig) rig = start.wait(**publisher);
  if (!rig) return ended_by(rig.error());
  if (!*rig) return kDone;
  Rig& shop = **rig;
  const drivers::SourceInfo& info = shop.source->info();
  const StereoModel& model = shop.stereo.model();
  Output output{std::move(**publisher),
                {model.width, model.height, config->lcm.images_channel.empty() ? 0.0 : config->lcm.images_rate_hz},
                std::nullopt,
                {},
                {}};
  if (!options.trajectory.empty()) {
    auto trajectory = TrajectorySink::open(options.trajectory);
    if (!trajectory) return ended_by(trajectory.error());
    output.trajectory.emplace(std::move(*trajectory));
  }
  describe(info, shop.size, model);
  spdlog::info("sending {}, {} and {} to {}", config->lcm.delta_channel, config->lcm.pose_channel,
               config->lcm.status_channel, config->lcm.url);

  Recording recording(config->recording, info, config->source.speed <= 0.0 && !info.live);
  if (config->recording.at_start) {
    // The odometry is what it is for: without a recording it goes on, and VO_HEALTH says so.
    if (const auto ok = recording.start(); !ok) report(ok.error());
  }
  output.publisher.copy_to([&recording](const std::string& channel, const std::uint8_t* data, std::size_t size) {
    recording.add(channel, data, size);
  });

  schedule_workers(config->realtime, shop.stereo);
  PipelineWork work;
  work.prepare = [&shop](FrameSlot& slot) { shop.stereo.prepare(slot.frame); };
  work.stereo = [&shop](FrameSlot& slot) { return shop.stereo.run(slot.pair, slot.frame); };
  work.odometry = [&shop, &output](FrameSlot& slot) {
    auto done = shop.odometry.run(slot.pair.stamp_ns, slot.frame);
    output.tap.offer(slot.pair.stamp_ns, slot.frame.left.cview(), slot.frame.disparity.cview());
    return done;
  };
  work.estimate = [&shop]() -> const vo::Estimate& { return shop.odometry.estimate(); };
  if (!config->lcm.movers_channel.empty()) {
    work.movers = [&shop]() -> const vo::Movers& { return shop.odometry.movers(); };
  }
  work.reset = [&shop] { shop.odometry.reset(); };
  work.output = [&output](const PublishedFrame& frame) { output(frame); };
  PipelineOptions pipeline_options;
  pipeline_options.speed = config->source.speed;
  pipeline_options.errors_are_final = config->source.type != "recording";  // a torn pair is skipped and counted
  pipeline_options.stereo.cpu = config->realtime.stereo_cpu;
  pipeline_options.stereo.fifo_priority = config->realtime.stereo_priority;
  pipeline_options.odometry.cpu = config->realtime.odometry_cpu;
  pipeline_options.odometry.fifo_priority = config->realtime.odometry_priority;
  pipeline_options.output.fifo_priority = config->realtime.output_priority;
  pipeline_options.catch_up_frames = config->realtime.catch_up_frames;
  const std::string description = info.description;
  const bool info_live = info.live;
  auto examined = examine_first_pairs(std::move(shop.source), [](const std::string& line) { spdlog::warn(line); });
  auto pipeline = Pipeline::start(pipeline_options, std::move(work), record_pairs(std::move(examined), recording));
  if (!pipeline) return ended_by(pipeline.error());
  for (const std::string& missing : pipeline->shortfalls()) spdlog::warn("without real-time rights: {}", missing);

  {
    Commands commands(*pipeline, recording);
    commands.listen(*config);
    if (start.reload_asked()) reload(options, *config, output, recording);
    watch(*pipeline, output, recording, commands, signals, service, description,
          [&] { reload(options, *config, output, recording); });
  }
  if (!pipeline->wait_finished(kPatienceNs)) {
    report({"a stage does not end", description, "the daemon ends without the frames on their way"});
    std::fflush(nullptr);
    std::_Exit(kBadInput);  // its thread cannot be joined
  }
  if (const auto ok = recording.stop(); !ok) report(ok.error());
  const PipelineCounts counts = pipeline->counts();
  spdlog::info("{} frames: {} poses sent ({} valid), {} dropped, {} rejected", counts.grabbed, counts.published,
               output.sent.valid.load(), counts.dropped, counts.rejected);
  if (!info_live && counts.source_errors > 0) spdlog::warn("{} pairs of the recording skipped", counts.source_errors);
  if (const std::string finding = pipeline->source_finding(); !finding.empty()) spdlog::warn(finding);
  int exit_code = kDone;
  if (output.trajectory) {
    if (const auto ok = output.trajectory->close(); !ok) exit_code = (report(ok.error()), kBadInput);
  }
  if (const auto ok = pipeline->outcome(); !ok) {
    exit_code = ended_by(ok.error());
    if (info_live) exit_code = unexpected_end();
  }
  return exit_code;
}

}  // namespace cliquevo::daemon
