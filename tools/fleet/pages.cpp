// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/pages.h"

#include <cstdio>

#include <fmt/format.h>

#include "drivers/own_folder.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/fleet/isolated.h"
#include "tools/fleet/unit.h"

namespace cliquevo::tools::fleet {

namespace {

Result<void> write_page(const FleetResults& results, const UnitRow& row, const drivers::OwnFolder& folder,
                        const std::string& file) {
  const auto drawing = find_drawing("fleet report");
  if (!drawing) return drawing.error();
  const Plan& plan = results.plan;
  UnitWatcher watcher;
  watcher.any_build = true;
  watcher.make_report = [&] { return (*drawing)->run_report(); };
  watcher.finish = [&](const UnitRun& run) -> Result<void> {
    // Replays repeat to the last bit; a page of another run than the table's would mislead.
    if (nlohmann::json::parse(run.result, nullptr, false) != row.result) {
      return Error{"its replay differs from the result", plan.unit_name(row.unit),
                   "make the report with the build that computed it"};
    }
    const std::string stats = run.log.stats_json(run.source, run.model, run.end.wall_s, run.reference);
    const std::string summary = run.log.summary(run.end.wall_s, run.reference);
    return folder.write(file, run.outputs.report->page({plan.unit_name(row.unit), summary, stats,
                                                        plan.configuration_of(row.unit).yaml, run.model},
                                                       run.log, run.reference));
  };
  const auto texts = compute_unit(plan, row.unit, watcher);
  return texts ? Result<void>() : Result<void>(texts.error());
}

}  // namespace

std::map<std::string, std::string> make_pages(const FleetResults& results, std::size_t most) {
  std::map<std::string, std::string> out;
  if (most == 0) return out;
  const auto fleet = drivers::OwnFolder::open(results.folder);
  const auto folder = fleet ? fleet->below("pages") : Result<drivers::OwnFolder>(fleet.error());
  if (!folder) {
    warn(folder.error());
    return out;
  }
  std::map<std::string, bool> tried;
  for (const WorstFrame& worst : worst_frames(results, std::size_t{1} << 20U)) {
    const UnitRow& row = results.rows[worst.row];
    if (!tried.emplace(row.unit.key, true).second) continue;
    if (tried.size() > most) break;
    const std::string file = row.unit.key + ".html";
    if (!folder->written_ns(file)) {
      std::fputs(fmt::format("replaying {} for its page\n", results.plan.unit_name(row.unit)).c_str(), stderr);
      const Error crash{"its replay crashed", results.plan.unit_name(row.unit), "replay it alone to see why"};
      const IsolatedEnd end = run_isolated([&] { return write_page(results, row, *folder, file); }, crash);
      if (end.error) {
        warn({"no page: " + end.error->what, end.error->where, end.error->remedy});
        continue;
      }
    }
    out[row.unit.key] = "pages/" + file;
  }
  return out;
}

}  // namespace cliquevo::tools::fleet
