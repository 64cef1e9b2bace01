// SPDX-License-Identifier: BSD-3-Clause
#include "tools/source_argument.h"

#include <utility>

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
  drivers::RecordingOptions options = config.recording;
  options.path = argument.text;
  options.pingpong = false;
  if (!argument.calibration.empty()) options.calibration = argument.calibration;
  if (argument.rate_hz) options.rate_hz = argument.rate_hz;
  if (argument.first) options.first = *argument.first;
  if (argument.last) options.last = *argument.last;
  if (argument.every) options.every = *argument.every;
  if (argument.pair_tolerance_s) options.pair_tolerance_s = argument.pair_tolerance_s;
  if (argument.bayer) options.bayer = *argument.bayer;
  return drivers::open_recording(options);
}

}  // namespace

bool is_simulator(const std::string& source) {
  return source == kSimulator || source.starts_with(std::string(kSimulator) + ":");
}

Result<void> check_source(const SourceArgument& argument) {
  if (is_simulator(argument.text)) {
    if (!argument.calibration.empty() || argument.rate_hz || argument.first || argument.last || argument.every ||
        argument.pair_tolerance_s || argument.bayer) {
      return Error{
          "wrong usage", argument.text,
          "--calibration, --rate, --first, --last, --every, --pair-tolerance and --bayer are for recordings; the "
          "simulator takes sim:frames=N,every=K,rate_hz=R"};
    }
    if (argument.text == kSimulator) return {};
    const auto parsed = drivers::parse_simulator_options(argument.text.substr(4));
    return parsed ? Result<void>() : parsed.error();
  }
  if (argument.first && argument.last && *argument.last < *argument.first) {
    return Error{"wrong usage", "--last " + std::to_string(*argument.last),
                 "give a pair that is not before --first " + std::to_string(*argument.first)};
  }
  return {};
}

Result<std::unique_ptr<drivers::FrameSource>> open_source(const SourceArgument& argument,
                                                          const daemon::SourceConfig& config) {
  return is_simulator(argument.text) ? open_simulated(argument, config) : open_recorded(argument, config);
}

}  // namespace cliquevo::tools
