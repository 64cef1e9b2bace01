// SPDX-License-Identifier: BSD-3-Clause
// Everything that a fleet's results say, as JSON: what the page is drawn from, and programs read.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "tools/comparison.h"
#include "tools/fleet/plan.h"
#include "tools/fleet/store.h"

namespace cliquevo::tools::fleet {

// A unit with what the store has of it.
struct UnitRow {
  Unit unit;
  nlohmann::json result;   // null: not computed
  nlohmann::json cost;     // null: not known
  nlohmann::json failure;  // null where there is a result, or nothing was tried
  RunFigures figures;      // where there is a result

  bool done() const { return !result.is_null(); }
};

struct FleetResults {
  std::string folder;
  Plan plan;
  std::vector<UnitRow> rows;  // in the plan's order

  const std::string& recording(const UnitRow& row) const { return plan.recording_of(row.unit).name; }
  const std::string& configuration(const UnitRow& row) const { return plan.configuration_of(row.unit).name; }
};

// The results of the plan in force in a fleet's folder.
Result<FleetResults> gather(const std::string& folder);

// One configuration against another, recording by recording.
struct FleetComparison {
  std::string a;  // the baseline
  std::string b;
  Comparison comparison;
};
// baseline: a configuration's name, then all others are held against it; or another fleet's folder, then each
// configuration against the one of the same name there (the only one, where either has just one). Empty: nothing.
// Errors: no such configuration or fleet, nothing in common.
Result<std::vector<FleetComparison>> compare_fleet(const FleetResults& results, const std::string& baseline,
                                                   const Gates& gates);

// A frame among the worst of all recordings.
struct WorstFrame {
  std::size_t row = 0;  // in FleetResults::rows
  nlohmann::json frame;
};
std::vector<WorstFrame> worst_frames(const FleetResults& results, std::size_t most);

// pages: of units by their keys, relative to the report.
nlohmann::json report_json(const FleetResults& results, const std::vector<FleetComparison>& comparisons,
                           const Gates& gates, const std::map<std::string, std::string>& pages);
// The few lines for a terminal.
std::string report_text(const nlohmann::json& report);

}  // namespace cliquevo::tools::fleet
