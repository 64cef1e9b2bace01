// SPDX-License-Identifier: BSD-3-Clause
// Pages about a run, an evaluation, a comparison or a fleet: one file each, made of the view's own parts, that opens
// from disk.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "daemon/pipeline/trajectory_file.h"
#include "tools/drawing.h"
#include "tools/run_log.h"
#include "tools/view/album.h"

namespace cliquevo::tools {

std::string run_report(const RunTexts& texts, const RunLog& log, const std::optional<RunReference>& reference,
                       const view::Album& album);
// result: as `eval --json` prints it.
std::string evaluation_report(const std::string& title, const nlohmann::json& result,
                              const daemon::Trajectory& estimate, const std::vector<PosePair>& pairs);
// comparison: as `compare --json` prints it.
std::string comparison_report(const std::string& title, const nlohmann::json& comparison);
// fleet: as `fleet report --json` prints it; configurations: every key in force, of each.
std::string fleet_report(const std::string& title, const nlohmann::json& fleet, const std::string& configurations);

}  // namespace cliquevo::tools
