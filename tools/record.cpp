// SPDX-License-Identifier: BSD-3-Clause
// cliquevo record: what a source delivers into an LCM event log.
#include "tools/record.h"

#include <memory>
#include <string>

#include <fmt/format.h>

#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/pacer.h"
#include "daemon/pipeline/source.h"
#include "drivers/describe.h"
#include "drivers/recorder.h"
#include "tools/exit_code.h"
#include "tools/progress.h"
#include "tools/skipped_pairs.h"
#include "tools/source_argument.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

constexpr std::int64_t kMegabyte = 1'000'000;

struct RecordArguments {
  SourceArgument source;
  daemon::ConfigArgument config;
  std::string out;
  std::int64_t max_file_mb = 0;
  std::int64_t max_total_mb = 0;
  double seconds = 0.0;
  double speed = 0.0;
  double wait_s = 0.0;
};

Result<std::unique_ptr<drivers::FrameSource>> open(const RecordArguments& arguments) {
  const auto config = daemon::read_config(arguments.config);
  if (!config) return config.error();
  if (!arguments.source.text.empty()) return open_source(arguments.source, config->source);
  return daemon::open_source_within(config->source, arguments.wait_s, StopOnSignal::asked);
}

int run(const RecordArguments& arguments) {
  if (arguments.source.text.empty() && arguments.config.empty()) {
    return report({"wrong usage", "record", "name a SOURCE, or a --config with one"}, kWrongUsage);
  }
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  const StopOnSignal signals;
  auto source = open(arguments);
  if (!source) return report(source.error());
  const drivers::SourceInfo& info = (*source)->info();
  drivers::RecorderOptions options;
  options.path = arguments.out;
  options.max_total_bytes = arguments.max_total_mb * kMegabyte;
  options.max_file_bytes = arguments.max_file_mb * kMegabyte;
  if (options.max_file_bytes == 0 && options.max_total_bytes > 0) options.max_file_bytes = options.max_total_bytes / 4;
  options.wait_when_full = !info.live;
  auto recorder = drivers::Recorder::start(options, info);
  if (!recorder) return report(recorder.error());
  fmt::print("{}\n", drivers::describe_source(info));
  std::fflush(stdout);

  Progress progress(info.frame_count);
  daemon::Pacer pacer(arguments.speed > 0.0 ? arguments.speed : 1.0);
  drivers::StereoPair pair;
  std::optional<Error> error;
  std::int64_t count = 0;
  std::optional<TimestampNs> first_ns;
  SkippedPairs skipped;
  const std::int64_t most_skipped = std::max<std::int64_t>(1000, info.frame_count);
  while (!StopOnSignal::asked() && !error) {
    const auto more = (*source)->next(pair);
    if (!more) {
      if (info.live) {
        error = more.error();
        break;
      }
      skipped.add(pair.index, more.error());
      if (skipped.count() > most_skipped) error = more.error();
      continue;
    }
    if (!*more) break;
    if (!info.live && arguments.speed > 0.0) StopOnSignal::sleep_until(pacer.due_ns(pair.stamp_ns, monotonic_ns()));
    if (!first_ns) first_ns = pair.stamp_ns;
    if (arguments.seconds > 0.0 && static_cast<double>(pair.stamp_ns - *first_ns) * 1e-9 >= arguments.seconds) break;
    recorder->add(pair, drivers::log_utime(info, pair));
    progress.update(++count, 0.0, "recorded");
    error = recorder->failure();
  }
  progress.finish();
  const Result<void> stopped = recorder->stop();
  const drivers::RecorderCounts counts = recorder->counts();
  fmt::print("{}: {} pairs, {:.1f} MB in {} files, {} left out\n", arguments.out, counts.pairs,
             static_cast<double>(counts.bytes) * 1e-6, counts.files, counts.left_out);
  if (!stopped) return report(stopped.error());
  if (error) return report(*error);
  return kDone;
}

}  // namespace

void add_record_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<RecordArguments>();
  CLI::App* record = app.add_subcommand("record", "Write what a source delivers into an LCM event log");
  record->add_option("SOURCE", arguments->source.text,
                     "A recording, sim, or sim:key=value,...; left out: the configuration's source (cameras)");
  record->add_option("--out", arguments->out, "New log; other LCM tools expect a name on .lcm")
      ->required()
      ->type_name("FILE.lcm");
  daemon::add_config_options(*record, arguments->config, "Configuration with the source");
  record->add_option("--max-file-mb", arguments->max_file_mb, "Begin a new file (FILE-000.lcm, ...) at this size")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000}))
      ->type_name("MB");
  record->add_option("--max-total-mb", arguments->max_total_mb, "Remove the oldest files beyond this size of all")
      ->check(CLI::Range(std::int64_t{4}, std::int64_t{100'000'000}))
      ->type_name("MB");
  record->add_option("--seconds", arguments->seconds, "End after so much of the source's time")
      ->check(CLI::PositiveNumber)
      ->type_name("S");
  record->add_option("--speed", arguments->speed, "Times recorded pace; left out: as fast as it goes")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  record
      ->add_option("--wait", arguments->wait_s, "Wait so long for cameras that are not there yet (default: not at all)")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  add_eye_options(*record, arguments->source);
  record->footer(
      "The log holds VO_STEREO (the pairs as grabbed, not compressed) and VO_CALIBRATION; whatever ends the writing, "
      "it\n"
      "can be read up to its last whole event. `cliquevo replay FILE.lcm` plays it, lcm-logplayer too.\n"
      "Examples:\n"
      "  cliquevo record --config rig.yaml --out drive.lcm --max-total-mb 20000\n"
      "  cliquevo record sim:frames=300 --out course.lcm");
  record->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
