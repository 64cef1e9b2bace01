// SPDX-License-Identifier: BSD-3-Clause
#include "tools/report.h"

#include <fstream>
#include <sys/utsname.h>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/plot.h"
#include "tools/view/check_words.h"

namespace cliquevo::tools {

namespace {

using nlohmann::json;

// Names need not be UTF-8; the page must be.
std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

std::string machine() {
  std::string processor;
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; processor.empty() && std::getline(file, line);) {
    if (line.starts_with("model name")) processor = line.substr(std::min(line.size(), line.find(':') + 2));
  }
  utsname system{};
  uname(&system);
  return fmt::format("cliquevo {}\n{} {} {}\n{}, {} processors\n", CLIQUEVO_VERSION, system.sysname, system.release,
                     system.machine, processor.empty() ? "processor unknown" : processor,
                     std::thread::hardware_concurrency());
}

// Of the report's map: to the right, and forward.
json point_from_above(const Eigen::Vector3d& p) { return {p.x(), p.z()}; }

json reference_json(const std::string& name, const std::vector<PosePair>& pairs, bool align) {
  const AgainstReference against = against_reference(pairs, align);
  json out = {{"name", name},
              {"aligned", align},
              {"way", json::array()},
              {"index", json::array()},
              {"distance", against.distance_m},
              {"error", against.error_m}};
  for (const Eigen::Vector3d& p : against.reference) out["way"].push_back(point_from_above(p));
  for (const PosePair& pair : pairs) out["index"].push_back(pair.estimate_index);
  return out;
}

json lines_json(const std::string& text) {
  json out = json::array();
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    out.push_back({{"text", text.substr(begin, end - begin)}, {"warn", false}});
    begin = end + 1;
  }
  return out;
}

std::string sentence(const RunLog& log, const std::optional<RunReference>& reference) {
  const std::size_t failed = log.failed().size();
  std::string out = fmt::format("{} frames over {:.2f} m: {}", log.frames().size(), log.distance_m(),
                                failed == 0 ? "none failed" : fmt::format("{} failed", failed));
  if (log.skipped().count() > 0) out += fmt::format(", {} pairs skipped", log.skipped().count());
  if (!reference || reference->pairs.size() < 2) return out + "; no reference to judge them by.";
  const Evaluation e = evaluate(reference->pairs, {});
  if (reference->align) return out + fmt::format("; ATE {:.4f} m against {}.", e.ate_m, reference->name);
  out += fmt::format("; {:.3f} m off at the end", e.end_m);
  if (e.end_pct) out += fmt::format(" ({:.3f} % of the way)", *e.end_pct);
  return out + fmt::format(" against {}.", reference->name);
}

std::string titled(const json& value) {
  return value.is_number_integer() ? value.dump() : value.is_null() ? "-" : fmt::format("{:.6g}", value.get<double>());
}

}  // namespace

std::string run_report(const RunTexts& texts, const RunLog& log, const std::optional<RunReference>& reference,
                       const view::Album& album) {
  json stats = json::parse(texts.stats_json, nullptr, false);
  stats.erase("frames");
  json data = {{"title", texts.title},
               {"sentence", sentence(log, reference)},
               {"lines", lines_json(texts.summary)},
               {"configuration", texts.configuration},
               {"machine", machine()},
               {"stats", std::move(stats)}};
  data.update(view::check_words());
  if (reference && reference->pairs.size() >= 2) {
    data["reference"] = reference_json(reference->name, reference->pairs, reference->align);
  }
  std::string text = text_of(data);
  text.pop_back();  // the album writes its own JSON
  return view::report_page(text + ",\"records\":" + album.records() + ",\"thumbnails\":" + album.thumbnails() +
                           ",\"worst\":" + album.worst() + "}");
}

std::string evaluation_report(const std::string& title, const json& result, const daemon::Trajectory& estimate,
                              const std::vector<PosePair>& pairs) {
  const bool align = estimate.format == daemon::TrajectoryFormat::tum;
  json way = json::array();
  for (const daemon::StampedPose& pose : estimate.poses) way.push_back(point_from_above(pose.T_world_camera.t));
  json figures = json::array();
  for (const auto& [key, value] : result.items()) {
    if (!value.is_array()) figures.push_back({key, titled(value)});
  }
  json segments = json::array();
  for (const json& row : result["by_length"]) {
    segments.push_back(
        {titled(row["length_m"]), titled(row["segments"]), titled(row["t_err_pct"]), titled(row["r_err_deg_m"])});
  }
  return view::report_page(
      text_of({{"title", title},
               {"sentence", fmt::format("{} poses compared: ATE {:.4f} m, {:.4f} m off at the end.", pairs.size(),
                                        result["ate_m"].get<double>(), result["end_m"].get<double>())},
               {"way", way},
               {"reference", reference_json("reference", pairs, align)},
               {"tables",
                {{{"title", "Segments"},
                  {"head", {"length [m]", "segments", "translation [%]", "rotation [deg/m]"}},
                  {"rows", segments}},
                 {{"title", "Figures"}, {"head", {"figure", "value"}}, {"rows", figures}}}},
               {"machine", machine()}}));
}

std::string comparison_report(const std::string& title, const json& comparison) {
  const bool worse = comparison["beyond_gate"].get<bool>();
  return view::report_page(
      text_of({{"title", title},
               {"sentence", fmt::format("B is {} than the gate of {:.2f} allows.", worse ? "worse" : "not worse",
                                        comparison["gate"].get<double>())},
               {"comparison", comparison},
               {"machine", machine()}}));
}

std::string fleet_report(const std::string& title, const json& fleet, const std::string& configurations) {
  const json& units = fleet["units"];
  std::string all = fmt::format("{} recordings, {} of {} units computed", fleet["recordings"].get<std::size_t>(),
                                units["done"].get<std::size_t>(), units["all"].get<std::size_t>());
  if (units["failed"] != 0) all += fmt::format(", {} failed", units["failed"].get<std::size_t>());
  all += '.';
  json lines = json::array();
  if (const json& cost = fleet["cost"]; cost.contains("frames_a_second_a_core")) {
    lines.push_back(
        {{"text", fmt::format("{:.0f} frames a second and {:.0f} units an hour on one core, {:.1f} core hours",
                              cost["frames_a_second_a_core"].get<double>(), cost["units_an_hour_a_core"].get<double>(),
                              cost["wall_s"].get<double>() / 3600.0)},
         {"warn", false}});
  }
  return view::report_page(text_of({{"title", title},
                                    {"sentence", all},
                                    {"lines", lines},
                                    {"fleet", fleet},
                                    {"configuration", configurations},
                                    {"machine", machine()}}));
}

}  // namespace cliquevo::tools
