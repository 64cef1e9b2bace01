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

#include "core/rt/memory.h"
#include "core/rt/thread.h"
#include "daemon/command_receiver.h"
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
#include "daemon/source.h"
#include "daemon/stages.h"
#include "daemon/trajectory_sink.h"
#include "drivers/describe.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kTickNs = 100'000'000;        // how often the watchdog is fed
constexpr std::int64_t kSecondNs = 1'000'000'000;    // health
constexpr std::int64_t kPatienceNs = 5 * kSecondNs;  // for frames on their way once stopping

Result<Config> load(const DaemonOptions& options) {
  return options.config.empty() ? Result<Config>(default_config()) : read_config(options.config);
}

// What the working threads use.
struct Workshop {
  StereoStage stereo;
  OdometryStage odometry;
};

Result<std::unique_ptr<Workshop>> make_workshop(const Config& config, const drivers::SourceInfo& source) {
  auto stereo = StereoStage::make(config.stereo, source);
  if (!stereo) return stereo.error();
  auto odometry = OdometryStage::make(config.odometry, source, *stereo);
  if (!odometry) return odometry.error();
  return std::make_unique<Workshop>(Workshop{std::move(*stereo), std::move(*odometry)});
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

void describe(const drivers::SourceInfo& source, const StereoModel& model) {
  spdlog::info(drivers::describe_source(source));
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
      service.status("waiting for a route for LCM messages");
      service.ready();
    }
    service.feed_watchdog();
    const int signal = signals.wait(kSecondNs);
    if (signal == SIGTERM || signal == SIGINT) return std::optional<Publisher>();
  }
}

void obey(const command_t& command, Pipeline& pipeline, Recording& recording) {
  if (command.command == command_t::RESET_POSE) {
    spdlog::info("resetting the pose: asked to by a message");
    pipeline.request_reset();
  } else if (command.command == command_t::START_RECORDING) {
    if (const auto ok = recording.start(); !ok) report(ok.error());
  } else if (command.command == command_t::STOP_RECORDING) {
    if (const auto ok = recording.stop(); !ok) report(ok.error());
  } else {
    spdlog::warn("command {} is not known: ignored", static_cast<int>(command.command));
  }
}

Result<std::optional<CommandReceiver>> listen(const Config& config, Pipeline& pipeline, Recording& recording) {
  std::optional<CommandReceiver> receiver;
  if (config.lcm.command_channel.empty()) return receiver;
  auto started = CommandReceiver::start(config.lcm.url, config.lcm.command_channel,
                                        [&](const command_t& c) { obey(c, pipeline, recording); });
  if (!started) return started.error();
  receiver.emplace(std::move(*started));
  return receiver;
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
  void give(const Findings& findings) {
    const auto [calibration, vehicle_part] = findings.read();
    if (calibration.noticeable() && !std::exchange(calibration_told_, true)) spdlog::warn(vo::describe(calibration));
    if (vehicle_part.frames > 0 && !std::exchange(view_told_, true)) spdlog::warn(vo::describe(vehicle_part));
  }

 private:
  bool calibration_told_ = false;
  bool view_told_ = false;
};

// Feeds the watchdog, reports, and waits for the end of the source or a signal to stop.
void watch(Pipeline& pipeline, Output& output, Recording& recording, const Signals& signals, Service& service,
           const std::string& source, const std::function<void()>& on_hangup) {
  Health health(pipeline, output.sent, output.findings, source);
  Advice advice;
  std::int64_t next_report_ns = monotonic_ns() + kSecondNs;
  while (!pipeline.wait_finished(0)) {
    const int signal = signals.wait(kTickNs);
    if (signal == SIGTERM || signal == SIGINT) {
      spdlog::info("stopping: asked to by signal {}", signal);
      break;
    }
    if (signal == SIGHUP) {
      service.reloading();
      on_hangup();
      service.reloaded();
    }
    if (health.may_feed_watchdog()) service.feed_watchdog();
    const std::int64_t now_ns = monotonic_ns();
    if (now_ns >= next_report_ns) {
      next_report_ns += kSecondNs * (1 + (now_ns - next_report_ns) / kSecondNs);
      output.publisher.publish(health.update(now_ns, recording.status()));
      advice.give(output.findings);
      service.status(health.status_text());
      spdlog::debug(health.status_text());
    }
    if (health.ready()) service.ready();
  }
  service.stopping();
  pipeline.stop();
}

}  // namespace

int check(const DaemonOptions& options) {
  const auto config = load(options);
  if (!config) return report(config.error()), kBadInput;
  if (const auto ok = config->check(); !ok) return report(ok.error()), kBadInput;
  const auto source = open_source(config->source);
  if (!source) return report(source.error()), kBadInput;
  const auto workshop = make_workshop(*config, (*source)->info());
  if (!workshop) return report(workshop.error()), kBadInput;
  fmt::print("# {}\n", drivers::describe_source((*source)->info()));
  fmt::print("{}", effective_config_yaml(*config));
  return kDone;
}

int run(const DaemonOptions& options) {
  const Signals signals;
  Service service;
  auto config = load(options);
  if (!config) return report(config.error()), kBadInput;
  if (const auto ok = config->check(); !ok) return report(ok.error()), kBadInput;
  set_up_log(config->log_level);
  if (config->realtime.lock_memory) {
    const std::string refused = rt::lock_memory();
    if (!refused.empty()) spdlog::warn("without real-time rights: memory is not locked: {}", refused);
  }

  auto source = open_source(config->source);
  if (!source) return report(source.error()), kBadInput;
  const drivers::SourceInfo& info = (*source)->info();
  auto workshop = make_workshop(*config, info);
  if (!workshop) return report(workshop.error()), kBadInput;
  auto publisher = make_publisher(*config, signals, service);
  if (!publisher) return report(publisher.error()), kBadInput;
  if (!*publisher) return kDone;
  const StereoModel& model = (*workshop)->stereo.model();
  Output output{std::move(**publisher),
                {model.width, model.height, config->lcm.images_channel.empty() ? 0.0 : config->lcm.images_rate_hz},
                std::nullopt,
                {},
                {}};
  if (!options.trajectory.empty()) {
    auto trajectory = TrajectorySink::open(options.trajectory);
    if (!trajectory) return report(trajectory.error()), kBadInput;
    output.trajectory.emplace(std::move(*trajectory));
  }
  describe(info, model);
  spdlog::info("sending {}, {} and {} to {}", config->lcm.delta_channel, config->lcm.pose_channel,
               config->lcm.status_channel, config->lcm.url);

  Recording recording(config->recording, info, config->source.speed <= 0.0 && !info.live);
  if (config->recording.at_start) {
    if (const auto ok = recording.start(); !ok) return report(ok.error()), kBadInput;
  }
  output.publisher.copy_to([&recording](const std::string& channel, const std::uint8_t* data, std::size_t size) {
    recording.add(channel, data, size);
  });

  Workshop& shop = **workshop;
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
  pipeline_options.stereo.cpu = config->realtime.stereo_cpu;
  pipeline_options.stereo.fifo_priority = config->realtime.stereo_priority;
  pipeline_options.odometry.cpu = config->realtime.odometry_cpu;
  pipeline_options.odometry.fifo_priority = config->realtime.odometry_priority;
  pipeline_options.output.fifo_priority = config->realtime.output_priority;
  pipeline_options.catch_up_frames = config->realtime.catch_up_frames;
  const std::string description = info.description;
  auto examined = examine_first_pairs(std::move(*source), [](const std::string& line) { spdlog::warn(line); });
  auto pipeline = Pipeline::start(pipeline_options, std::move(work), record_pairs(std::move(examined), recording));
  if (!pipeline) return report(pipeline.error()), kBadInput;
  for (const std::string& missing : pipeline->shortfalls()) spdlog::warn("without real-time rights: {}", missing);

  {
    const auto commands = listen(*config, *pipeline, recording);
    if (!commands) return report(commands.error()), kBadInput;
    watch(*pipeline, output, recording, signals, service, description,
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
  int exit_code = kDone;
  if (output.trajectory) {
    if (const auto ok = output.trajectory->close(); !ok) exit_code = (report(ok.error()), kBadInput);
  }
  if (const auto ok = pipeline->outcome(); !ok) exit_code = (report(ok.error()), kBadInput);
  return exit_code;
}

}  // namespace cliquevo::daemon
