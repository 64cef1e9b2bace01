// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/report_data.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "tools/run_log.h"

namespace cliquevo::tools::fleet {

using nlohmann::json;

namespace {

constexpr std::size_t kMostWorst = 40;
constexpr int kBins = 20;

json or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

// What is reported of each unit and of each configuration.
struct Figure {
  const char* name;
  const char* unit;
  std::optional<double> (*of)(const UnitRow&);
};
std::optional<double> failed_pct(const UnitRow& row) {
  if (row.figures.frames <= 0.0) return std::nullopt;
  return 100.0 * row.figures.failed / row.figures.frames;
}
constexpr Figure kFigures[] = {
    {"segments", "%", [](const UnitRow& r) { return r.figures.segments_pct; }},
    {"rotation", "deg/m", [](const UnitRow& r) { return r.figures.rotation_deg_m; }},
    {"end", "%", [](const UnitRow& r) { return r.figures.end_pct; }},
    {"ATE", "m", [](const UnitRow& r) { return r.figures.ate_m; }},
    {"failed", "% of frames", failed_pct},
    {"quality", "of 100", [](const UnitRow& r) { return r.figures.quality; }},
    {"inliers", "median", [](const UnitRow& r) { return r.figures.inliers; }},
    {"time", "ms a frame", [](const UnitRow& r) { return r.figures.time_ms; }},
};

std::vector<double> values_of(const FleetResults& results, const std::string& configuration, const Figure& figure) {
  std::vector<double> out;
  for (const UnitRow& row : results.rows) {
    if (!row.done() || results.configuration(row) != configuration) continue;
    if (const auto value = figure.of(row)) out.push_back(*value);
  }
  return out;
}

json units_json(const FleetResults& results, const std::map<std::string, std::string>& pages) {
  json out = json::array();
  for (const UnitRow& row : results.rows) {
    if (!row.done()) continue;
    json line = {{"recording", results.recording(row)},
                 {"configuration", results.configuration(row)},
                 {"key", row.unit.key},
                 {"frames", row.result.value("frames", 0)},
                 {"failed", row.result.value("failed", 0)},
                 {"skipped", row.result.value("skipped", 0)},
                 {"distance_m", row.result.value("distance_m", 0.0)},
                 {"figures", json::object()}};
    for (const Figure& figure : kFigures) line["figures"][figure.name] = or_null(figure.of(row));
    if (const auto page = pages.find(row.unit.key); page != pages.end()) line["page"] = page->second;
    out.push_back(std::move(line));
  }
  return out;
}

json configurations_json(const FleetResults& results) {
  json out = json::array();
  for (const Configuration& c : results.plan.configurations) {
    json line = {{"name", c.name}, {"figures", json::object()}};
    std::size_t units = 0;
    std::int64_t frames = 0;
    std::int64_t failed = 0;
    double distance_m = 0.0;
    for (const UnitRow& row : results.rows) {
      if (!row.done() || results.configuration(row) != c.name) continue;
      ++units;
      frames += row.result.value("frames", std::int64_t{0});
      failed += row.result.value("failed", std::int64_t{0});
      distance_m += row.result.value("distance_m", 0.0);
    }
    line.update({{"units", units}, {"frames", frames}, {"failed", failed}, {"distance_m", distance_m}});
    for (const Figure& figure : kFigures) {
      const std::vector<double> values = values_of(results, c.name, figure);
      if (values.empty()) continue;
      const Spread spread = spread_of(values);
      double sum = 0.0;
      for (const double v : values) sum += v;
      line["figures"][figure.name] = {{"mean", sum / static_cast<double>(values.size())},
                                      {"median", spread.median},
                                      {"p95", spread.p95},
                                      {"max", spread.max}};
    }
    out.push_back(std::move(line));
  }
  return out;
}

// Counts over equal bins from the least to the greatest value that any configuration has.
json distributions_json(const FleetResults& results) {
  json out = json::array();
  for (const Figure& figure : kFigures) {
    std::vector<std::pair<std::string, std::vector<double>>> series;
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    for (const Configuration& c : results.plan.configurations) {
      series.emplace_back(c.name, values_of(results, c.name, figure));
      for (const double v : series.back().second) {
        least = std::min(least, v);
        most = std::max(most, v);
      }
    }
    if (!(most > least)) continue;  // nothing, or all the same
    const double width = (most - least) / kBins;
    json line = {{"figure", figure.name}, {"unit", figure.unit}, {"edges", json::array()}, {"series", json::array()}};
    for (int k = 0; k <= kBins; ++k) line["edges"].push_back(least + k * width);
    for (const auto& [name, values] : series) {
      std::vector<int> counts(kBins, 0);
      for (const double v : values) ++counts[static_cast<std::size_t>(std::min(kBins - 1.0, (v - least) / width))];
      line["series"].push_back({{"configuration", name}, {"counts", counts}});
    }
    out.push_back(std::move(line));
  }
  return out;
}

// Why frames were refused, by check; of all recordings.
json reasons_json(const FleetResults& results) {
  std::map<std::string, std::map<std::string, std::int64_t>> counts;  // check, configuration
  for (const UnitRow& row : results.rows) {
    if (!row.done()) continue;
    for (const auto& [check, count] : row.result["reasons"].items()) {
      counts[check][results.configuration(row)] += count.get<std::int64_t>();
    }
  }
  json out = json::array();
  for (const auto& [check, by_configuration] : counts) out.push_back({{"check", check}, {"frames", by_configuration}});
  return out;
}

// Units without a result and why, together where the reason is the same; recordings that no unit could be made of.
json failures_json(const FleetResults& results) {
  std::map<std::string, json> by_reason;
  const auto add = [&](const std::string& what, json line) {
    json& entry = by_reason[what];
    if (entry.is_null()) entry = {{"what", what}, {"units", json::array()}};
    entry["units"].push_back(std::move(line));
  };
  for (const UnitRow& row : results.rows) {
    if (!row.failure.is_object()) continue;
    const std::string what = row.failure.value("what", "");
    add(what,
        {{"recording", results.recording(row)},
         {"configuration", results.configuration(row)},
         {"line", fmt::format("{}: {}: {}", what, row.failure.value("where", ""), row.failure.value("remedy", ""))},
         {"host", row.failure.value("host", "")},
         {"said", row.failure.value("said", "")}});
  }
  for (const Recording& r : results.plan.recordings) {
    if (!r.problem.empty())
      add("cannot be opened", {{"recording", r.name}, {"configuration", ""}, {"line", r.problem}});
  }
  json out = json::array();
  for (auto& [what, entry] : by_reason) out.push_back(std::move(entry));
  return out;
}

json worst_json(const FleetResults& results, const std::map<std::string, std::string>& pages) {
  json out = json::array();
  for (const WorstFrame& worst : worst_frames(results, kMostWorst)) {
    const UnitRow& row = results.rows[worst.row];
    json line = worst.frame;
    line["recording"] = results.recording(row);
    line["configuration"] = results.configuration(row);
    line["source"] = results.plan.recording_of(row.unit).source;
    if (const auto page = pages.find(row.unit.key); page != pages.end()) line["page"] = page->second;
    out.push_back(std::move(line));
  }
  return out;
}

json cost_json(const FleetResults& results) {
  double wall_s = 0.0;
  double replay_s = 0.0;
  double frames = 0.0;
  std::size_t units = 0;
  std::map<std::string, int> hosts;
  for (const UnitRow& row : results.rows) {
    if (!row.cost.is_object()) continue;
    ++units;
    wall_s += row.cost.value("wall_s", 0.0);
    replay_s += row.cost.value("replay_s", 0.0);
    frames += row.cost.value("frames", 0.0);
    ++hosts[row.cost.value("host", "")];
  }
  json out = {{"units", units}, {"wall_s", wall_s}, {"replay_s", replay_s}, {"frames", frames}, {"hosts", hosts}};
  if (wall_s <= 0.0) return out;
  out["units_an_hour_a_core"] = 3600.0 * static_cast<double>(units) / wall_s;
  out["frames_a_second_a_core"] = frames / wall_s;
  return out;
}

json comparisons_json(const std::vector<FleetComparison>& comparisons, const Gates& gates) {
  json out = json::array();
  for (const FleetComparison& c : comparisons) {
    out.push_back({{"a", c.a}, {"b", c.b}, {"comparison", comparison_json(c.comparison, gates)}});
  }
  return out;
}

}  // namespace

json report_json(const FleetResults& results, const std::vector<FleetComparison>& comparisons, const Gates& gates,
                 const std::map<std::string, std::string>& pages) {
  std::size_t done = 0;
  std::size_t failed = 0;
  for (const UnitRow& row : results.rows) {
    done += row.done() ? 1 : 0;
    failed += row.failure.is_object() ? 1 : 0;
  }
  return {{"cliquevo_fleet_report", 1},
          {"version", results.plan.version},
          {"build", results.plan.build},
          {"made_unix_s", static_cast<std::int64_t>(std::time(nullptr))},
          {"recordings", results.plan.recordings.size()},
          {"units",
           {{"all", results.rows.size()},
            {"done", done},
            {"failed", failed},
            {"waiting", results.rows.size() - done - failed}}},
          {"cost", cost_json(results)},
          {"configurations", configurations_json(results)},
          {"table", units_json(results, pages)},
          {"distributions", distributions_json(results)},
          {"comparisons", comparisons_json(comparisons, gates)},
          {"worst", worst_json(results, pages)},
          {"reasons", reasons_json(results)},
          {"failures", failures_json(results)}};
}

std::string report_text(const json& report) {
  const json& units = report["units"];
  std::string out =
      fmt::format("{} recordings, {} units: {} done, {} failed, {} waiting\n", report["recordings"].get<std::size_t>(),
                  units["all"].get<std::size_t>(), units["done"].get<std::size_t>(), units["failed"].get<std::size_t>(),
                  units["waiting"].get<std::size_t>());
  const json& cost = report["cost"];
  if (cost.contains("units_an_hour_a_core")) {
    out += fmt::format("{:.0f} frames a second on a core, {:.0f} units an hour\n",
                       cost["frames_a_second_a_core"].get<double>(), cost["units_an_hour_a_core"].get<double>());
  }
  for (const json& c : report["configurations"]) {
    out += fmt::format("{}: {} of {} frames failed over {:.1f} m", printable(c["name"].get<std::string>()),
                       c["failed"].get<std::int64_t>(), c["frames"].get<std::int64_t>(), c["distance_m"].get<double>());
    for (const char* name : {"segments", "end"}) {
      if (!c["figures"].contains(name)) continue;
      out += fmt::format(", {} median {:.4f} % most {:.4f} %", name, c["figures"][name]["median"].get<double>(),
                         c["figures"][name]["max"].get<double>());
    }
    out += "\n";
  }
  for (const json& failure : report["failures"]) {
    out += fmt::format("{} x {}: {}\n", failure["units"].size(), printable(failure["what"].get<std::string>()),
                       printable(failure["units"][0]["line"].get<std::string>()));
  }
  for (const json& c : report["comparisons"]) {
    std::size_t beyond = 0;
    for (const json& run : c["comparison"]["runs"]) beyond += run["beyond_gate"].get<bool>() ? 1 : 0;
    out += fmt::format("{} against {}: {} of {} recordings beyond the gate\n", printable(c["b"].get<std::string>()),
                       printable(c["a"].get<std::string>()), beyond, c["comparison"]["runs"].size());
  }
  return out;
}

}  // namespace cliquevo::tools::fleet
