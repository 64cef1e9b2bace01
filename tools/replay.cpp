// SPDX-License-Identifier: BSD-3-Clause
// cliquevo replay: a recording or the simulator through stereo and odometry.
#include <charconv>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/effective_config.h"
#include "drivers/describe.h"
#include "tools/commands.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"
#include "tools/reference.h"
#include "tools/replay_run.h"
#include "tools/source_argument.h"

namespace cliquevo::tools {

namespace {

using daemon::TrajectoryFormat;

struct ReplayArguments {
  SourceArgument source;
  daemon::ConfigArgument config;
  std::string trajectory;
  TrajectoryFormat format = TrajectoryFormat::kitti;
  std::string stats;
  std::string plot;
  std::string report;
  std::string reference;
  double speed = 0.0;  // 0 = as fast as possible
  std::string lcm_url;
  bool strict = false;
};

// Files of the end, opened at the start.
struct EndFiles {
  std::optional<OutputFile> stats;
  std::optional<OutputFile> plot;
  std::optional<OutputFile> report;
};

Result<EndFiles> open_end_files(const ReplayArguments& arguments) {
  EndFiles out;
  if (!arguments.stats.empty()) {
    auto file = OutputFile::open(arguments.stats, "statistics");
    if (!file) return file.error();
    out.stats = std::move(*file);
  }
  if (!arguments.plot.empty()) {
    auto file = OutputFile::open(arguments.plot, "plot");
    if (!file) return file.error();
    out.plot = std::move(*file);
  }
  if (!arguments.report.empty()) {
    auto file = OutputFile::open(arguments.report, "report");
    if (!file) return file.error();
    out.report = std::move(*file);
  }
  return out;
}

Result<ReplayOutputs> open_outputs(const ReplayArguments& arguments, const daemon::Config& config,
                                   const Drawing* drawing) {
  ReplayOutputs out;
  out.speed = arguments.speed;
  out.strict = arguments.strict;
  if (!arguments.trajectory.empty()) {
    auto writer = daemon::TrajectoryWriter::open(arguments.trajectory, arguments.format);
    if (!writer) return writer.error();
    out.trajectory = std::move(*writer);
  }
  if (!arguments.report.empty()) out.report = drawing->run_report();
  if (!arguments.lcm_url.empty()) {
    daemon::LcmConfig lcm = config.lcm;
    lcm.url = arguments.lcm_url;
    auto publisher = daemon::Publisher::make(lcm, config.T_body_camera);
    if (publisher) {
      out.publisher = std::move(*publisher);
    } else {
      warn(publisher.error());
    }
  }
  return out;
}

// The reference given, or what the source brings along; none of it can fail the run but a reference that was given.
Result<std::optional<RunReference>> find_reference(const ReplayArguments& arguments, const RunLog& log,
                                                   const drivers::SourceInfo& info) {
  if (!arguments.reference.empty()) {
    auto reference = reference_from_file(arguments.reference, log.frames(), info);
    if (!reference) return reference.error();
    return std::optional(std::move(*reference));
  }
  if (is_simulator(arguments.source.text)) return reference_from_truth(log.frames());
  const std::string beside = reference_beside(arguments.source.text);
  if (beside.empty()) return std::optional<RunReference>();
  auto reference = reference_from_file(beside, log.frames(), info);
  if (!reference) return std::optional<RunReference>();
  return std::optional(std::move(*reference));
}

std::string title_of(const ReplayArguments& arguments) {
  const std::string name = std::filesystem::path(arguments.source.text).lexically_normal().filename().string();
  return name.empty() ? arguments.source.text : name;
}

RunPicture picture_of(const ReplayArguments& arguments, const RunLog& log,
                      const std::optional<RunReference>& reference) {
  RunPicture out;
  out.title = title_of(arguments);
  for (const FrameRecord& frame : log.frames()) {
    out.trajectory.push_back(frame.estimate.T_world_camera);
    out.inliers.push_back(frame.estimate.inliers);
  }
  out.failed = log.failed();
  if (reference) {
    out.pairs = reference->pairs;
    out.align = reference->align;
  }
  return out;
}

// Statistics and picture; the first error of them.
Result<void> write_end_files(const ReplayArguments& arguments, EndFiles& files, const RunLog& log,
                             const std::string& stats, const std::optional<RunReference>& reference,
                             const Drawing* drawing) {
  Result<void> written;
  if (files.stats) written = files.stats->write(stats);
  if (!files.plot || log.frames().empty()) return written;
  const auto png = drawing->plot(picture_of(arguments, log, reference), *plot_format(arguments.plot));
  const Result<void> drawn = png ? files.plot->write(*png) : Result<void>(png.error());
  return written ? drawn : written;
}

// The exit code of a run that got to its end.
int judge(const ReplayArguments& arguments, const RunLog& log) {
  if (log.frames().empty() && !log.skipped().empty()) {
    return report({"no pair could be played", arguments.source.text,
                   "see the first: " + log.skipped().entries().front().error.line()});
  }
  if (log.frames().empty()) return report({"no pair to play", arguments.source.text, "choose other pairs"});
  const std::vector<std::size_t> failed = log.failed();
  if (arguments.strict && !failed.empty()) {
    const FrameRecord& first = log.frames()[failed.front()];
    return report({fmt::format("{} of {} frames failed", failed.size(), log.frames().size()),
                   fmt::format("first at pair {} ({})", first.index, vo::status_name(first.estimate.status)),
                   "without --strict this is accepted"},
                  kNotStrictEnough);
  }
  return kDone;
}

int run(const ReplayArguments& arguments) {
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  if (auto format = plot_format(arguments.plot); !format) return report(format.error(), kWrongUsage);
  const Drawing* drawing = nullptr;
  if (!arguments.plot.empty() || !arguments.report.empty()) {
    auto found = find_drawing(arguments.plot.empty() ? "replay --report" : "replay --plot");
    if (!found) return report(found.error());
    drawing = *found;
  }
  const auto read = daemon::read_config(arguments.config);
  if (!read) return report(read.error());
  const daemon::Config& config = *read;
  auto source = open_source(arguments.source, config.source);
  if (!source) return report(source.error());
  const drivers::SourceInfo& info = (*source)->info();
  auto pipeline = daemon::FramePipeline::make({config.stereo, config.odometry, config.rectify}, info);
  if (!pipeline) return report(pipeline.error());
  auto files = open_end_files(arguments);
  if (!files) return report(files.error());
  auto outputs = open_outputs(arguments, config, drawing);
  if (!outputs) return report(outputs.error());

  fmt::print("{}\n{}\n", drivers::describe_source(info), drivers::describe_geometry(pipeline->model()));
  std::fflush(stdout);
  RunLog log;
  const ReplayEnd end = run_replay(**source, *pipeline, *outputs, log);
  log.set_finding((*source)->finding());

  int exit_code = kDone;
  const auto fail = [&exit_code](const Error& error) { exit_code = report(error); };
  if (end.error) exit_code = report(*end.error, end.by_strictness ? kNotStrictEnough : kBadInput);
  std::optional<RunReference> reference;
  if (!log.frames().empty()) {
    auto found = find_reference(arguments, log, info);
    if (found) {
      reference = std::move(*found);
    } else {
      fail(found.error());
    }
    fmt::print("{}", log.summary(end.wall_s, reference));
    if (const std::string remarks = (*source)->status(); !remarks.empty()) fmt::print("source: {}\n", remarks);
  }
  if (auto ok = write_end_files(arguments, *files, log, log.stats_json(info, pipeline->model(), end.wall_s, reference),
                                reference, drawing);
      !ok) {
    fail(ok.error());
  }
  if (files->report && !log.frames().empty()) {
    const std::string stats = log.stats_json(info, pipeline->model(), end.wall_s, reference);
    const std::string text = log.summary(end.wall_s, reference);
    const std::string page = outputs->report->page(
        {title_of(arguments), text, stats, daemon::effective_config_yaml(config), pipeline->model()}, log, reference);
    if (auto ok = files->report->write(page); !ok) fail(ok.error());
  }
  return exit_code != kDone ? exit_code : judge(arguments, log);
}

// "max" or a positive number.
bool parse_speed(const std::string& text, double& speed) {
  if (text == "max") {
    speed = 0.0;
    return true;
  }
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), speed);
  return failed == std::errc{} && end == text.data() + text.size() && speed >= 1e-6 && speed < 1e6;
}

template <typename T>
auto into(std::optional<T>& target) {
  return [&target](const T& value) { target = value; };
}

void add_source_options(CliCommand replay, SourceArgument& source) {
  replay
      .add_option("SOURCE", source.text,
                  "A recording's folder (KITTI, KITTI-360, EuRoC, two folders of images, images of both cameras in one "
                  "folder: recognised by what is in it), an LCM log, sim, or sim:key=value,...")
      .required();
  add_calibration_options(replay, source);
  replay.add_option_function<std::int64_t>("--first", into(source.first), "First pair to play, counted from 0")
      .not_negative()
      .type_name("I");
  replay.add_option_function<std::int64_t>("--last", into(source.last), "Last pair to play")
      .not_negative()
      .type_name("I");
  replay.add_option_function<std::int64_t>("--every", into(source.every), "Play every K-th pair")
      .positive()
      .type_name("K");
  replay
      .add_option_function<double>("--pair-tolerance", into(source.pair_tolerance_s),
                                   "Most time between the images of a pair, s (default a quarter period)")
      .not_negative()
      .type_name("S");
  const std::map<std::string, drivers::Bayer> patterns{
      {"auto", drivers::Bayer::automatic}, {"none", drivers::Bayer::none}, {"rggb", drivers::Bayer::rggb},
      {"bggr", drivers::Bayer::bggr},      {"grbg", drivers::Bayer::grbg}, {"gbrg", drivers::Bayer::gbrg}};
  replay
      .add_option_function<std::string>(
          "--bayer", [&source, patterns](const std::string& name) { source.bayer = patterns.at(name); },
          "The images are raw Bayer mosaics of this pattern, or none; default auto: where the images show it")
      .one_of({"auto", "none", "rggb", "bggr", "grbg", "gbrg"})
      .type_name("PATTERN");
  add_recording_options(replay, source);
}

// What is written about the run.
void add_picture_options(CliCommand replay, ReplayArguments& arguments) {
  replay.add_option("--stats", arguments.stats, "Write each frame's verdict, counts, errors and times as JSON")
      .type_name("FILE.json");
  replay
      .add_option("--plot", arguments.plot,
                  "Draw the trajectory and its error over distance: PNG, SVG or PDF by the name's ending")
      .type_name("FILE.png|svg|pdf");
  replay
      .add_option("--report", arguments.report,
                  "Write a page about the run into one file: map, errors, verdicts, times, the worst frames as seen")
      .type_name("FILE.html");
}

}  // namespace

void add_replay_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  const CliCommand replay =
      app.add_subcommand("replay", "Run a recording or the simulator through stereo and odometry: poses and verdicts");
  add_source_options(replay, arguments->source);
  daemon::add_config_options(replay, arguments->config, "Configuration (cliquevo config sample prints every key)");
  replay
      .add_option("--trajectory", arguments->trajectory,
                  "Write a pose a pair: rectified left camera in its first frame")
      .type_name("FILE");
  replay
      .add_option_function<std::string>(
          "--format",
          [arguments](const std::string& name) {
            arguments->format = name == "tum" ? TrajectoryFormat::tum : TrajectoryFormat::kitti;
          },
          "Of the trajectory: kitti (12 numbers a line, default) or tum (seconds, position, quaternion)")
      .one_of({"kitti", "tum"})
      .type_name("NAME");
  add_picture_options(replay, *arguments);
  replay
      .add_option("--reference", arguments->reference,
                  "True trajectory for the plot and the summary (default: the recording's own poses.txt, "
                  "groundtruth.tum, EuRoC's or TUM VI's ground truth or KITTI-360 poses, the simulator's truth)")
      .type_name("FILE");
  replay
      .add_option_function<std::string>(
          "--speed",
          [arguments](const std::string& text) {
            if (!parse_speed(text, arguments->speed)) {
              refuse_value("--speed", "'" + text + "' is neither max nor a number from 0.000001 to 1000000");
            }
          },
          "max (default) or N times the recorded pace")
      .type_name("max|N");
  replay.add_option("--lcm", arguments->lcm_url, "Publish every frame over LCM, e.g. udpm://239.255.76.67:7667?ttl=0")
      .type_name("URL");
  replay.add_flag("--strict", arguments->strict,
                  "Exit with 3 if a frame failed, and at once at a pair that cannot be played");
  replay.footer(
      "Every pair is processed, in order; one that cannot be read, or whose stamp steps back, is skipped and named: "
      "its\n"
      "line of the trajectory holds the pose before it. Exit codes: 0 done; 1 bad input or environment; 2 wrong "
      "usage;\n"
      "3 --strict.\n"
      "The simulator's keys are those under source.simulator in config/cliquevo.yaml.\n"
      "Examples:\n"
      "  cliquevo replay sim --plot run.png --report run.html\n"
      "  cliquevo replay sim:course=walking,frames=400,noise_seed=3 --stats run.json\n"
      "  cliquevo replay /data/drive_0027 --trajectory poses.txt --stats run.json --plot run.png\n"
      "  cliquevo replay /data/indoor --every 2 --format tum --trajectory poses.tum --speed 1 --lcm udpm://");
  replay.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
