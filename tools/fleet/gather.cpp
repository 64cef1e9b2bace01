// SPDX-License-Identifier: BSD-3-Clause
// From the store to rows, and rows of two fleets beside each other.
#include <algorithm>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/fleet/report_data.h"
#include "tools/fleet/unit.h"

namespace cliquevo::tools::fleet {

using nlohmann::json;

namespace {

json parsed(const std::optional<std::string>& text) {
  json out = text ? json::parse(*text, nullptr, false) : json(nullptr);
  return out.is_object() ? out : json(nullptr);
}

std::vector<NamedRun> runs_of(const FleetResults& results, const std::string& configuration) {
  std::vector<NamedRun> out;
  for (const UnitRow& row : results.rows) {
    if (row.done() && results.configuration(row) == configuration) out.push_back({results.recording(row), row.figures});
  }
  return out;
}

std::vector<std::string> configuration_names(const FleetResults& results) {
  std::vector<std::string> out;
  for (const Configuration& c : results.plan.configurations) out.push_back(c.name);
  return out;
}

bool anything_in_common(const Comparison& comparison) {
  return std::any_of(comparison.runs.begin(), comparison.runs.end(),
                     [](const ComparedRun& run) { return run.missing_in.empty(); });
}

// Units that are still to come, or failed, are missing in B and so beyond the gate; of the baseline they are listed.
FleetComparison beside(const FleetResults& a, const std::string& name_a, const FleetResults& b,
                       const std::string& name_b, const Gates& gates, bool other_fleet) {
  FleetComparison out;
  out.a = other_fleet ? fmt::format("{} in {}", name_a, a.folder) : name_a;
  out.b = name_b;
  out.comparison = compare_runs(runs_of(a, name_a), runs_of(b, name_b), gates);
  return out;
}

}  // namespace

Result<FleetResults> gather(const std::string& folder) {
  auto plan = read_plan(folder + "/" + kPlanFile);
  if (!plan) return plan.error();
  auto store = Store::open(plan->cache);
  if (!store) return store.error();
  FleetResults out{folder, std::move(*plan), {}};
  for (const Unit& unit : out.plan.units) {
    UnitRow row{unit, nullptr, nullptr, nullptr, {}};
    const auto result = store->read(unit.key, Part::result);
    const auto cost = store->read(unit.key, Part::cost);
    if (result) {
      auto figures = figures_of_result(*result, cost.value_or(""), unit.key);
      if (!figures) return figures.error();
      row.figures = *figures;
      row.result = parsed(result);
      row.cost = parsed(cost);
    } else {
      row.failure = parsed(store->read(unit.key, Part::failure));
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

Result<std::vector<FleetComparison>> compare_fleet(const FleetResults& results, const std::string& baseline,
                                                   const Gates& gates) {
  std::vector<FleetComparison> out;
  if (baseline.empty()) return out;
  const std::vector<std::string> names = configuration_names(results);
  std::error_code none;
  if (std::find(names.begin(), names.end(), baseline) != names.end()) {
    for (const std::string& name : names) {
      if (name != baseline) out.push_back(beside(results, baseline, results, name, gates, false));
    }
  } else if (std::filesystem::exists(baseline + "/" + kPlanFile, none)) {
    const auto other = gather(baseline);
    if (!other) return other.error();
    const std::vector<std::string> theirs = configuration_names(*other);
    for (const std::string& name : names) {
      const bool same = std::find(theirs.begin(), theirs.end(), name) != theirs.end();
      if (!same && (names.size() > 1 || theirs.size() > 1)) continue;
      out.push_back(beside(*other, same ? name : theirs.front(), results, name, gates, true));
    }
  } else {
    return Error{"no such baseline", baseline,
                 fmt::format("name a fleet's folder, or a configuration: {}", fmt::join(names, "; "))};
  }
  const bool any =
      std::any_of(out.begin(), out.end(), [](const FleetComparison& c) { return anything_in_common(c.comparison); });
  if (!any) return Error{"nothing to compare", baseline, "name a baseline with the same recordings"};
  return out;
}

std::vector<WorstFrame> worst_frames(const FleetResults& results, std::size_t most) {
  std::vector<WorstFrame> out;
  for (std::size_t k = 0; k < results.rows.size(); ++k) {
    const json& result = results.rows[k].result;
    if (!result.is_object() || !result.contains("worst")) continue;
    for (const json& frame : result["worst"]) out.push_back({k, frame});
  }
  std::stable_sort(out.begin(), out.end(), [](const WorstFrame& a, const WorstFrame& b) {
    return a.frame.value("badness", 0.0) > b.frame.value("badness", 0.0);
  });
  if (out.size() > most) out.resize(most);
  return out;
}

}  // namespace cliquevo::tools::fleet
