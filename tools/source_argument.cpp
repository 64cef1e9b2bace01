// SPDX-License-Identifier: BSD-3-Clause
#include "tools/source_argument.h"

#include <utility>

#include <fmt/format.h>

#include "drivers/camera_order_watch.h"
#include "drivers/recording.h"
#include "drivers/simulator.h"

namespace cliquevo::tools {

namespace {

constexpr const char* kSimulator = "sim";

Result<std::unique_ptr<drivers::FrameSource>> open_simulated(const SourceArgument& argument,
                                                             const daemon::SourceConfig& config) {
  drivers::SimulatorOptions options = config.simulator;
  if (argument.text != kSimulator) {
    const auto parsed = drivers::parse_simulator_options(argument.text.substr(4));
    if (!parsed) return parsed.error();
    options = *parsed;
  }
  auto simulator = drivers::open_simulator(options);
  if (!simulator) return simulator.error();
  return std::unique_ptr<drivers::FrameSource>(std::move(*simulator));
}

Result<std::unique_ptr<drivers::FrameSource>> open_recorded(const SourceArgument& argument,
                                                            const daemon::SourceConfig& config) {
  auto recording = drivers::open_recording(recording_options(argument, config));
  if (recording && argument.print_notes) {
    for (const std::string& note : (*recording)->info().calibration.notes)
      fmt::print(stderr, "calibration: {}\n", note);
  }
  return recording;
}

}  // namespace

drivers::RecordingOptions recording_options(const SourceArgument& argument, const daemon::SourceConfig& config) {
  drivers::RecordingOptions options = config.recording;
  options.path = argument.text;
  options.pingpong = false;
  if (!argument.calibration.empty()) options.calibration = argument.calibration;
  const drivers::CalibrationOptions& said = argument.calibration_options;
  if (said.baseline_unit_m > 0.0) options.calibration_options.baseline_unit_m = said.baseline_unit_m;
  if (said.rectified) options.calibration_options.rectified = true;
  if (said.readout_ms > 0.0) options.calibration_options.readout_ms = said.readout_ms;
  if (!said.lens.empty()) options.calibration_options.lens = said.lens;
  if (argument.rate_hz) options.rate_hz = argument.rate_hz;
  if (argument.first) options.first = *argument.first;
  if (argument.last) options.last = *argument.last;
  if (argument.every) options.every = *argument.every;
  if (argument.pair_tolerance_s) options.pair_tolerance_s = argument.pair_tolerance_s;
  if (argument.bayer) options.bayer = *argument.bayer;
  if (!argument.channel.empty()) options.channel = argument.channel;
  if (!argument.topics.empty()) options.topics = argument.topics;
  options.side_by_side = options.side_by_side || argument.side_by_side;
  return options;
}

void add_calibration_options(CliCommand command, SourceArgument& source) {
  command.add_option("--calibration", source.calibration, "Calibration instead of the recording's own")
      .type_name("FILE");
  command
      .add_option(
          "--baseline-unit", source.calibration_options.baseline_unit_m,
          "Metres a unit of the calibration's lengths: 0.025 for squares of 25 mm, 1 for metres in spite of all")
      .between(1e-6, 1e6)
      .type_name("M");
  command.add_flag("--rectified", source.calibration_options.rectified,
                   "The images are rectified by this calibration already");
  command
      .add_option("--lens", source.calibration_options.lens,
                  "What four distortion terms without a name are: plumb_bob or equidistant (OpenCV's fisheye)")
      .one_of({"plumb_bob", "equidistant"})
      .type_name("MODEL");
  command
      .add_option("--readout-ms", source.calibration_options.readout_ms,
                  "Rolling shutter: time from the first row's exposure to the last one's, ms")
      .between(0.0, 1000.0)
      .type_name("MS");
}

bool is_simulator(const std::string& source) {
  return source == kSimulator || source.starts_with(std::string(kSimulator) + ":");
}

Result<void> check_source(const SourceArgument& argument) {
  if (is_simulator(argument.text)) {
    if (argument.is_for_recordings()) {
      return Error{"wrong usage", argument.text,
                   "--calibration and its options, --rate, --first, --last, --every, --pair-tolerance, --bayer, "
                   "--channel, --topics and --side-by-side "
                   "are for recordings; the simulator takes sim:frames=N,every=K,rate_hz=R"};
    }
    if (argument.text == kSimulator) return {};
    const auto parsed = drivers::parse_simulator_options(argument.text.substr(4));
    return parsed ? Result<void>() : parsed.error();
  }
  // nan passes every test for too little or too much.
  if (argument.rate_hz && !(*argument.rate_hz >= 1e-3 && *argument.rate_hz <= 1e6)) {
    return Error{"wrong usage", "--rate", "give a rate of 0.001 to 1000000 Hz"};
  }
  if (argument.pair_tolerance_s && !(*argument.pair_tolerance_s >= 0.0 && *argument.pair_tolerance_s <= 3600.0)) {
    return Error{"wrong usage", "--pair-tolerance", "give 0 to 3600 s"};
  }
  if (argument.first && argument.last && *argument.last < *argument.first) {
    return Error{"wrong usage", "--last " + std::to_string(*argument.last),
                 "give a pair that is not before --first " + std::to_string(*argument.first)};
  }
  return {};
}

void add_recording_options(CliCommand command, SourceArgument& argument) {
  command
      .add_option_function<double>(
          "--rate", [&argument](double hz) { argument.rate_hz = hz; }, "Pairs a second, whatever times are there")
      .positive()
      .type_name("HZ");
  command.add_option("--channel", argument.channel, "Of a log with several stereo channels: the one to play")
      .type_name("NAME");
  command
      .add_option("--topics", argument.topics,
                  "Of a bag: the images of both cameras, and their camera_info where it is not beside them")
      .type_name("LEFT,RIGHT[,LEFT_INFO,RIGHT_INFO]");
  command.add_flag("--side-by-side", argument.side_by_side,
                   "Each image of the folder holds the left and the right one, side by side");
  command.add_flag("--swap-eyes", argument.swap_eyes, "Left and right are exchanged in the recording: put them right");
}

Result<std::unique_ptr<drivers::FrameSource>> open_source(const SourceArgument& argument,
                                                          const daemon::SourceConfig& config) {
  const bool simulated = is_simulator(argument.text);
  const bool swap = argument.swap_eyes || config.swap_eyes;
  auto source = simulated ? open_simulated(argument, config) : open_recorded(argument, config);
  const bool pictures_alone = !config.recording.needs_calibration;
  if (!source || ((simulated || pictures_alone) && !swap)) return source;
  return drivers::watch_camera_order(std::move(*source), swap);
}

}  // namespace cliquevo::tools
