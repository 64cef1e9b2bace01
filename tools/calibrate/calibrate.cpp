// SPDX-License-Identifier: BSD-3-Clause
// cliquevo calibrate: from a board in front of the cameras to a calibration file.
#include "tools/calibrate/calibrate.h"

#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "daemon/pipeline/command_line.h"
#include "daemon/pipeline/source.h"
#include "drivers/calibration/writers.h"
#include "drivers/calibration_file.h"
#include "tools/calibrate/capture.h"
#include "tools/calibrate/collect.h"
#include "tools/calibrate/from_driving.h"
#include "tools/calibrate/print_board.h"
#include "tools/calibrate/report.h"
#include "tools/calibrate/summary.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"
#include "tools/source_argument.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

constexpr double kFilmed_hz = 5.0;        // pairs that come so often show one motion
constexpr double kMostSpeed_px_s = 30.0;  // 0.3 px within 10 ms
constexpr double kNewsOfStills = 0.002;   // of the width: pictures taken one by one differ on purpose

struct CalibrateArguments {
  SourceArgument source;
  daemon::ConfigArgument config;
  std::string board;
  std::string out;
  std::string format = "opencv";
  std::string model = "auto";
  std::string compare;
  std::string report;
  std::int64_t most_views = 150;
  bool square_pixels = false;
  bool json = false;
  bool make_board = false;
  bool from_driving = false;
  bool page = false;
  view::ServerOptions server;
  std::string version;
};

std::string writer_names() {
  std::string out;
  for (const drivers::CalibrationWriter& writer : drivers::calibration_writers()) {
    out += fmt::format("{}{}", out.empty() ? "" : ", ", writer.name);
  }
  return out;
}

Result<daemon::Config> configuration(const CalibrateArguments& arguments) {
  daemon::ConfigArgument config = arguments.config;
  config.needs_calibration = arguments.from_driving;
  return daemon::read_config(config);
}

Result<std::unique_ptr<drivers::FrameSource>> open(const CalibrateArguments& arguments, daemon::Config config) {
  config.source.recording.needs_calibration = arguments.from_driving;
  if (arguments.source.text.empty()) return daemon::open_source(config.source);
  auto source = open_source(arguments.source, config.source);
  if (source || arguments.from_driving || config.source.recording.rate_hz) return source;
  // Pictures of a board need no times.
  config.source.recording.rate_hz = 1.0;
  auto without_times = open_source(arguments.source, config.source);
  return without_times ? std::move(without_times) : std::move(source);
}

Result<void> write_files(const CalibrateArguments& arguments, const StereoCalibration& calibration) {
  const drivers::CalibrationWriter* writer = drivers::find_calibration_writer(arguments.format);
  const auto files = writer->write(calibration, arguments.out);
  if (!files) return files.error();
  for (const drivers::CalibrationFile& file : *files) {
    auto out = OutputFile::open(file.path, "calibration");
    if (!out) return out.error();
    if (auto ok = out->write(file.text); !ok) return ok;
  }
  return {};
}

std::string source_name(const CalibrateArguments& arguments) {
  if (!arguments.source.text.empty()) return arguments.source.text;
  return arguments.config.file.empty() ? "the configuration" : arguments.config.file;
}

Error no_board(const Collected& collected, const CalibrateArguments& arguments) {
  const std::string remedy =
      collected.guess.empty()
          ? "name the board that is in the pictures; all of it must be seen, sharp, with a white border"
          : fmt::format("{}: name the board that is in the pictures", collected.guess);
  return {fmt::format("no {} found in {} pairs", arguments.board, collected.pairs), source_name(arguments), remedy};
}

Result<CalibrationResult> solve_views(const CalibrateArguments& arguments, const calibration::Board& board,
                                      const drivers::SourceInfo& info, Collected collected, CapturePage* page) {
  calibration::SolveOptions options;
  options.model = arguments.model;
  options.square_pixels = arguments.square_pixels;
  options.progress = [page](const std::string& step) {
    fmt::print(stderr, "solving: {}\n", step);
    if (page != nullptr) page->set_phase("solving", step);
  };
  auto solution = calibration::solve(board, collected.views, info.width, info.height, options);
  if (!solution) return solution.error();
  CalibrationResult result;
  result.board = board;
  result.solution = std::move(*solution);
  result.compared_with = arguments.compare;
  result.collected = std::move(collected);
  const calibration::Adjusted& adjusted = result.solution.adjusted;
  result.accuracy = calibration::accuracy(adjusted.rig, adjusted.covariance);
  result.coverage = calibration::coverage(board, result.solution);
  if (!arguments.compare.empty()) {
    const auto old = drivers::read_calibration(arguments.compare, info.width, info.height);
    if (!old) return old.error();
    result.movement = calibration::movement(adjusted.rig, adjusted.covariance, *old);
  }
  return result;
}

// Of cameras, and with a page: with guidance. What cannot be solved yet is said, and the looking goes on.
Result<CalibrationResult> calibrate_guided(const CalibrateArguments& arguments, const calibration::Board& board,
                                           const daemon::Config& config, drivers::FrameSource& source,
                                           CapturePage* page) {
  const drivers::SourceInfo& info = source.info();
  GuideOptions guide;
  guide.most_views = static_cast<std::size_t>(arguments.most_views);
  if (info.live && config.source.cameras.exposure_us) guide.exposure_s = 1e-6 * *config.source.cameras.exposure_us;
  Capture capture(source, board, guide, page);
  for (;;) {
    auto collected = capture.collect();
    if (!collected) return collected.error();
    const bool last = collected->ended || collected->stopped || collected->enough;
    auto result = collected->views.empty() ? Result<CalibrationResult>(no_board(*collected, arguments))
                                           : solve_views(arguments, board, info, std::move(*collected), page);
    if (result || last) return result;
    fmt::print(stderr, "{}\n", result.error().line());
    if (page != nullptr) page->set_phase("looking", result.error().line());
  }
}

Result<CalibrationResult> calibrate(const CalibrateArguments& arguments, const calibration::Board& board,
                                    const daemon::Config& config, drivers::FrameSource& source, CapturePage* page) {
  const drivers::SourceInfo& info = source.info();
  if (info.live || page != nullptr) return calibrate_guided(arguments, board, config, source, page);
  CollectOptions collect;
  collect.most_views = arguments.most_views;
  const bool stills = info.frame_count >= 0 && info.frame_count <= arguments.most_views;
  if (stills) collect.news_of_width = kNewsOfStills;
  if (!stills && info.rate_hz >= kFilmed_hz) collect.most_speed_px_s = kMostSpeed_px_s;
  auto collected = collect_views(source, board, collect);
  if (!collected) return collected.error();
  if (collected->views.empty()) return no_board(*collected, arguments);
  return solve_views(arguments, board, info, std::move(*collected), nullptr);
}

int run_from_driving(const CalibrateArguments& arguments) {
  const auto config = configuration(arguments);
  if (!config) return report(config.error());
  const StopOnSignal signals;
  const auto driven = calibrate_from_driving([&] { return open(arguments, *config); }, *config);
  if (!driven) return report(driven.error());
  if (auto ok = write_files(arguments, driven->calibration); !ok) return report(ok.error());
  if (arguments.json) {
    fmt::print("{}\n", to_json(*driven).dump(2));
  } else {
    fmt::print("{}{}: written\n", summary_of(*driven), arguments.out);
  }
  return kDone;
}

Result<void> write_result(const CalibrateArguments& arguments, const CalibrationResult& result) {
  if (auto ok = write_files(arguments, result.solution.rig().calibration()); !ok) return ok;
  if (arguments.report.empty()) return {};
  auto page = OutputFile::open(arguments.report, "report");
  if (!page) return page.error();
  return page->write(calibration_report(result));
}

Result<std::unique_ptr<CapturePage>> open_page(const CalibrateArguments& arguments, const std::string& source) {
  if (!arguments.page) return std::unique_ptr<CapturePage>();
  auto page = CapturePage::open(arguments.server, source, arguments.version);
  if (page) fmt::print(stderr, "{}\n", (*page)->address());
  return page;
}

int run_with_board(const CalibrateArguments& arguments, const calibration::Board& board) {
  const auto config = configuration(arguments);
  if (!config) return report(config.error());
  const StopOnSignal signals;
  auto source = open(arguments, *config);
  if (!source) return report(source.error());
  const auto page = open_page(arguments, (*source)->info().description);
  if (!page) return report(page.error());
  const auto result = calibrate(arguments, board, *config, **source, page->get());
  const auto written = result ? write_result(arguments, *result) : Result<void>(result.error());
  if (*page) {
    (*page)->set_phase(
        written ? "done" : "failed",
        written ? fmt::format("{}{}: written", summary_of(*result), arguments.out) : written.error().line());
    (*page)->linger();
  }
  if (!written) return report(written.error());
  if (arguments.json) {
    fmt::print("{}\n", to_json(*result).dump(2));
  } else {
    fmt::print("{}{}: written\n", summary_of(*result), arguments.out);
  }
  return kDone;
}

int run(const CalibrateArguments& arguments) {
  if (arguments.from_driving) {
    if (arguments.source.text.empty()) {
      return report({"wrong usage", "--from-driving", "name a recording as SOURCE"}, kWrongUsage);
    }
    if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
    return run_from_driving(arguments);
  }
  if (arguments.board.empty()) {
    return report({"wrong usage", "calibrate", "name the --board, or use --from-driving"}, kWrongUsage);
  }
  const auto board = calibration::parse_board(arguments.board);
  if (!board) return report(board.error(), kWrongUsage);
  if (arguments.make_board) {
    if (auto ok = print_board(*board, arguments.out); !ok) return report(ok.error());
    fmt::print("{}: print it at 100 %, then measure its ruler\n", arguments.out);
    return kDone;
  }
  if (arguments.source.text.empty() && arguments.config.empty()) {
    return report({"wrong usage", "calibrate", "name a SOURCE, or a --config with one"}, kWrongUsage);
  }
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  return run_with_board(arguments, *board);
}

void add_page_options(CliCommand command, CalibrateArguments& arguments) {
  command.add_flag("--page", arguments.page, "Guide on a page too: its address is printed");
  command.add_option("--port", arguments.server.port, "Port of the page, 0 = any that is free")
      .capture_default_str()
      .type_name("N");
  command
      .add_option("--listen", arguments.server.listen,
                  "Address to serve the page at; beyond loopback its address holds a token")
      .capture_default_str()
      .type_name("ADDR");
}

}  // namespace

void add_board_calibration_command(CliCommand app, int& exit_code, const std::string& version) {
  auto arguments = std::make_shared<CalibrateArguments>();
  arguments->version = version;
  const CliCommand command = app.add_subcommand("calibrate", kCalibratePurpose);
  command.add_option("SOURCE", arguments->source.text,
                     "A recording or folder of image pairs; left out: the configuration's source (cameras)");
  command
      .add_option("--board", arguments->board,
                  "KIND:COLSxROWS:SIZE_M: chessboard (inner corners, side of a square), charuco (squares, side of a "
                  "square[:marker's share]), aprilgrid (tags, side of a tag[:gap's share]), circles (dots, distance)")
      .type_name("BOARD");
  command.add_option("--out", arguments->out, "Calibration to write; with --make-board the board, FILE.pdf or FILE.svg")
      .required()
      .type_name("FILE");
  command.add_option("--format", arguments->format, "Of the file: " + writer_names())
      .checked_by([](const std::string& name) {
        return drivers::find_calibration_writer(name) != nullptr ? std::string() : "choose " + writer_names();
      })
      .type_name("NAME")
      .capture_default_str();
  command
      .add_option("--model", arguments->model,
                  "Lens: radtan, plumb_bob, rational, equidistant; auto: by views held out")
      .checked_by([](const std::string& name) {
        return name == "auto" || calibration::find_lens_model(name) != nullptr
                   ? std::string()
                   : std::string("choose auto, radtan, plumb_bob, rational or equidistant");
      })
      .type_name("NAME")
      .capture_default_str();
  command.add_flag("--square-pixels", arguments->square_pixels, "One focal length a camera");
  command.add_option("--compare", arguments->compare, "Say how far another calibration of this rig is off")
      .type_name("FILE");
  command.add_option("--report", arguments->report, "A page with the errors over the image").type_name("FILE.html");
  command.add_option("--max-views", arguments->most_views, "Stop looking after so many views")
      .between(std::int64_t{5}, std::int64_t{1000})
      .type_name("N")
      .capture_default_str();
  daemon::add_config_options(command, arguments->config, "Configuration with the source");
  add_page_options(command, *arguments);
  command.add_flag("--json", arguments->json, "Print the result as JSON");
  command.add_flag("--make-board", arguments->make_board, "Write the board to print, at true scale, instead");
  command.add_flag("--from-driving", arguments->from_driving,
                   "No board: correct the recording's calibration by what ordinary driving shows");
  add_calibration_options(command, arguments->source);
  add_recording_options(command, arguments->source);
  command.footer(
      "Ctrl-C ends the looking; what was collected is used. With cameras it guides, in the terminal and with --page "
      "on\n"
      "a page, takes views by itself, and ends when it is enough.\n"
      "Examples:\n"
      "  cliquevo calibrate --make-board --board charuco:9x6:0.03 --out board.pdf\n"
      "  cliquevo calibrate pairs/ --board chessboard:9x6:0.02423 --out rig.yaml --report rig.html\n"
      "  cliquevo calibrate drive/ --from-driving --out corrected.yaml\n"
      "  cliquevo calibrate --config rig.yaml --page --board aprilgrid:6x6:0.088:0.3 --out new.yaml --compare "
      "rig_old.yaml");
  command.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
