// SPDX-License-Identifier: BSD-3-Clause
// cliquevo info: what is in a source, and what of it would be played.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "drivers/describe.h"
#include "drivers/recording/streams.h"
#include "stereo/rectification.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/source_argument.h"

namespace cliquevo::tools {

namespace {

using nlohmann::json;

struct InfoArguments {
  SourceArgument source;
  bool json = false;
};

std::string describe(const drivers::RecordedStream& s) {
  std::string out = fmt::format("  {}  {}  {}", s.name, s.type, s.count);
  if (s.rate_hz > 0.0) {
    out += fmt::format(", {:.2f} Hz, {:.3f} s", s.rate_hz, static_cast<double>(s.last_ns - s.first_ns) * 1e-9);
  }
  if (s.gaps > 0) out += fmt::format(", {} gaps (longest {:.3f} s)", s.gaps, s.longest_gap_s);
  return printable(out);
}

void print_streams(const drivers::RecordedStreams& found) {
  fmt::print("{}\n", printable(found.kind));
  for (const drivers::RecordedStream& stream : found.streams) fmt::print("{}\n", describe(stream));
  if (!found.damage.empty()) fmt::print("damage: {}\n", printable(found.damage));
}

json as_json(const drivers::RecordedStreams& found) {
  json streams = json::array();
  for (const drivers::RecordedStream& s : found.streams) {
    streams.push_back({{"name", s.name},
                       {"type", s.type},
                       {"count", s.count},
                       {"first_ns", s.first_ns},
                       {"last_ns", s.last_ns},
                       {"rate_hz", s.rate_hz},
                       {"gaps", s.gaps},
                       {"longest_gap_s", s.longest_gap_s}});
  }
  return {{"kind", found.kind}, {"streams", streams}, {"damage", found.damage}};
}

json as_json(const CameraCalibration& c) {
  return {{"width", c.width}, {"height", c.height}, {"fx_px", c.fx_px},
          {"fy_px", c.fy_px}, {"cx_px", c.cx_px},   {"cy_px", c.cy_px}};
}

json played_json(const drivers::SourceInfo& info) {
  json out{{"description", info.description}, {"pairs", info.frame_count}, {"width", info.width},
           {"height", info.height},           {"rate_hz", info.rate_hz},   {"rectified", info.calibration.rectified}};
  json calibration{{"source", info.calibration.source},
                   {"notes", info.calibration.notes},
                   {"left", as_json(info.calibration.left)},
                   {"right", as_json(info.calibration.right)}};
  if (const auto chosen = stereo::choose_rectification(info.calibration)) {
    const StereoModel& m = chosen->model;
    calibration["rectified"] = {{"width", m.width},       {"height", m.height},        {"fx_px", m.fx_px},
                                {"fy_px", m.fy_px},       {"cx_px", m.cx_px},          {"cy_px", m.cy_px},
                                {"doffs_px", m.doffs_px}, {"baseline_m", m.baseline_m}};
  }
  out["calibration"] = calibration;
  return out;
}

void print_played(const drivers::SourceInfo& info) {
  fmt::print("{}\n", drivers::describe_source(info));
  if (const auto chosen = stereo::choose_rectification(info.calibration)) {
    fmt::print("{}\n", drivers::describe_geometry(chosen->model));
  }
}

std::string dump(const json& page) { return page.dump(2, ' ', false, json::error_handler_t::replace); }

int run(const InfoArguments& arguments) {
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  const daemon::SourceConfig config = daemon::default_config().source;
  json page = json::object();
  if (!is_simulator(arguments.source.text)) {
    const auto found = drivers::list_streams(recording_options(arguments.source, config));
    if (!found) return report(found.error());
    page = as_json(*found);
    if (!arguments.json) print_streams(*found);
  }
  const auto source = open_source(arguments.source, config);
  if (!source) {  // what is there has been listed; why it cannot be played is the error
    page["played"] = nullptr;
    if (arguments.json) fmt::print("{}\n", dump(page));
    return report(source.error());
  }
  page["played"] = played_json((*source)->info());
  if (arguments.json) {
    fmt::print("{}\n", dump(page));
  } else {
    print_played((*source)->info());
  }
  return kDone;
}

}  // namespace

void add_info_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<InfoArguments>();
  const CliCommand info = app.add_subcommand("info", "List what is in a recording, log, bag, video or the simulator");
  info.add_option("SOURCE", arguments->source.text, "As `cliquevo replay` takes it").required();
  info.add_flag("--json", arguments->json, "As JSON");
  add_calibration_options(info, arguments->source);
  add_recording_options(info, arguments->source);
  info.footer(
      "Each stream with its type, count, rate (of the median period), length and gaps (of more than 1.5 periods);\n"
      "then what would be played, with the calibration. Exit code 1 where nothing can be played: why is on stderr.\n"
      "Examples:\n"
      "  cliquevo info drive.mcap\n"
      "  cliquevo info /data/indoor --json");
  info.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
