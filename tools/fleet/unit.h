// SPDX-License-Identifier: BSD-3-Clause
// One unit, computed in this process.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "tools/comparison.h"
#include "tools/fleet/plan.h"
#include "tools/reference.h"
#include "tools/replay_run.h"

namespace cliquevo::tools::fleet {

struct UnitTexts {
  std::string result;  // JSON: figures, verdicts, reasons, the worst frames, the trajectory's hash; no time, no path
  std::string cost;    // JSON: host, seconds, times a frame
  std::string trajectory;  // as replay --trajectory writes it
};

// What else may be made of the run; the page of a report.
struct UnitRun {
  const daemon::Config& config;
  const drivers::SourceInfo& source;
  const StereoModel& model;
  const RunLog& log;
  const ReplayEnd& end;
  const ReplayOutputs& outputs;
  const std::optional<RunReference>& reference;
  const std::string& result;
};
struct UnitWatcher {
  std::function<std::unique_ptr<RunReport>()> make_report;  // gets every frame
  std::function<Result<void>(const UnitRun&)> finish;
  bool any_build = false;  // the result is not to be stored: another program than the plan's may compute it
};

// Replays it. Errors: not what was planned (another recording, calibration or build by now), cannot be opened, no pair
// could be played, interrupted.
Result<UnitTexts> compute_unit(const Plan& plan, const Unit& unit, const UnitWatcher& watcher = {});

// The part of a result that `compare` judges, from its JSON.
Result<RunFigures> figures_of_result(const std::string& result, const std::string& cost, const std::string& where);

}  // namespace cliquevo::tools::fleet
