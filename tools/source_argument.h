// SPDX-License-Identifier: BSD-3-Clause
// SOURCE on the command line: a recording's path, `sim`, or `sim:key=value,...`.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/cli_command.h"
#include "daemon/pipeline/config.h"
#include "drivers/calibration_file.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

struct SourceArgument {
  std::string text;
  std::string calibration;  // empty = the source's own
  drivers::CalibrationOptions calibration_options;
  std::optional<double> rate_hz;
  std::optional<std::int64_t> first;
  std::optional<std::int64_t> last;
  std::optional<std::int64_t> every;
  std::optional<double> pair_tolerance_s;
  std::optional<drivers::Bayer> bayer;
  std::string channel;  // empty = the log's only one
  std::string topics;   // empty = the bag's, by types and names
  bool side_by_side = false;
  bool swap_eyes = false;
  bool print_notes = true;  // what was assumed in reading the calibration, on stderr

  // Whether any option was given that is for recordings alone.
  bool is_for_recordings() const {
    return !calibration.empty() || !calibration_options.empty() || rate_hz || first || last || every ||
           pair_tolerance_s || bayer || !channel.empty() || !topics.empty() || side_by_side;
  }
};

// --calibration and the options that go with it.
void add_calibration_options(CliCommand command, SourceArgument& source);

bool is_simulator(const std::string& source);
// Whether SOURCE and the options beside it make sense together; an error is one of usage.
Result<void> check_source(const SourceArgument& argument);

// --rate, --channel, --topics, --side-by-side and --swap-eyes, for every command with a SOURCE.
void add_recording_options(CliCommand command, SourceArgument& argument);

// How the recording that SOURCE names is to be read.
drivers::RecordingOptions recording_options(const SourceArgument& argument, const daemon::SourceConfig& config);

// What the command line leaves open, the configuration decides (its simulator for a bare `sim`, its calibration, masks
// and so on for a recording). What was assumed in reading the calibration is printed on stderr.
Result<std::unique_ptr<drivers::FrameSource>> open_source(const SourceArgument& argument,
                                                          const daemon::SourceConfig& config);

}  // namespace cliquevo::tools
