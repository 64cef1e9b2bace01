// SPDX-License-Identifier: BSD-3-Clause
// cliquevo record: what a source delivers into an LCM event log.
#include "tools/record.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/pacer.h"
#include "daemon/pipeline/source.h"
#include "drivers/describe.h"
#include "drivers/recorder.h"
#include "tools/bag_recorder.h"
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

// An LCM log or an MCAP.
class RecordTarget {
 public:
  static Result<RecordTarget> start(const RecordArguments& arguments, const daemon::Config& config,
                                    const drivers::SourceInfo& info) {
    RecordTarget out;
    if (std::filesystem::path(arguments.out).extension() == ".mcap") {
      if (arguments.max_file_mb > 0 || arguments.max_total_mb > 0) {
        return Error{"wrong usage", arguments.out, "--max-file-mb and --max-total-mb are for LCM logs"};
      }
      auto bag = BagRecorder::start(arguments.out, !info.live, info, config.T_body_camera);
      if (!bag) return bag.error();
      out.bag_ = std::move(*bag);
      return out;
    }
    drivers::RecorderOptions options;
    options.path = arguments.out;
    options.max_total_bytes = arguments.max_total_mb * kMegabyte;
    options.max_file_bytes = arguments.max_file_mb * kMegabyte;
    if (options.max_file_bytes == 0 && options.max_total_bytes > 0)
      options.max_file_bytes = options.max_total_bytes / 4;
    options.wait_when_full = !info.live;
    auto log = drivers::Recorder::start(options, info);
    if (!log) return log.error();
    out.log_ = std::move(*log);
    return out;
  }

  void add(const drivers::StereoPair& pair, const drivers::SourceInfo& info) {
    if (bag_) bag_->add(pair);
    if (log_) log_->add(pair, drivers::log_utime(info, pair));
  }
  std::optional<Error> failure() const { return bag_ ? bag_->failure() : log_->failure(); }
  Result<void> stop() { return bag_ ? bag_->stop() : log_->stop(); }
  drivers::RecorderCounts counts() const { return bag_ ? bag_->counts() : log_->counts(); }

 private:
  std::optional<BagRecorder> bag_;
  std::optional<drivers::Recorder> log_;
};

Result<daemon::Config> config_of(const RecordArguments& arguments) { return daemon::read_config(arguments.config); }

Result<std::unique_ptr<drivers::FrameSource>> open(const RecordArguments& arguments, const daemon::Config& config) {
  if (!arguments.source.text.empty()) return open_source(arguments.source, config.source);
  return daemon::open_source_within(config.source, arguments.wait_s, StopOnSignal::received);
}

int run(const RecordArguments& arguments) {
  if (arguments.source.text.empty() && arguments.config.empty()) {
    return report({"wrong usage", "record", "name a SOURCE, or a --config with one"}, kWrongUsage);
  }
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  const StopOnSignal signals;
  const auto config = config_of(arguments);
  if (!config) return report(config.error());
  auto source = open(arguments, *config);
  if (!source) return report(source.error());
  const drivers::SourceInfo& info = (*source)->info();
  auto recorder = RecordTarget::start(arguments, *config, info);
  if (!recorder) return report(recorder.error(), recorder.error().what == "wrong usage" ? kWrongUsage : kBadInput);
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
  while (!StopOnSignal::received() && !error) {
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
    recorder->add(pair, info);
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

void add_record_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<RecordArguments>();
  const CliCommand record =
      app.add_subcommand("record", "Write what a source delivers into an LCM event log or an MCAP");
  record.add_option("SOURCE", arguments->source.text,
                    "A recording, sim, or sim:key=value,...; left out: the configuration's source (cameras)");
  record.add_option("--out", arguments->out, "New LCM log, or MCAP for ROS 2's tools by its name's ending")
      .required()
      .type_name("FILE.lcm|mcap");
  daemon::add_config_options(record, arguments->config, "Configuration with the source");
  record.add_option("--max-file-mb", arguments->max_file_mb, "Begin a new file (FILE-000.lcm, ...) at this size")
      .between(std::int64_t{1}, std::int64_t{1'000'000})
      .type_name("MB");
  record.add_option("--max-total-mb", arguments->max_total_mb, "Remove the oldest files beyond this size of all")
      .between(std::int64_t{4}, std::int64_t{100'000'000})
      .type_name("MB");
  record.add_option("--seconds", arguments->seconds, "End after so much of the source's time")
      .positive()
      .type_name("S");
  record.add_option("--speed", arguments->speed, "Times recorded pace; left out: as fast as it goes")
      .positive()
      .type_name("N");
  record
      .add_option("--wait", arguments->wait_s, "Wait so long for cameras that are not there yet (default: not at all)")
      .not_negative()
      .type_name("S");
  add_recording_options(record, arguments->source);
  record.footer(
      "The log holds VO_STEREO (the pairs as grabbed, not compressed) and VO_CALIBRATION; whatever ends the writing, "
      "it\n"
      "can be read up to its last whole event. `cliquevo replay FILE.lcm` plays it, lcm-logplayer too.\n"
      "Examples:\n"
      "  cliquevo record --config rig.yaml --out drive.lcm --max-total-mb 20000\n"
      "  cliquevo record sim:frames=300 --out course.lcm");
  record.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
