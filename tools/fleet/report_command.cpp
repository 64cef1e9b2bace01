// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/report_command.h"

#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "drivers/own_folder.h"
#include "tools/exit_code.h"
#include "tools/fleet/pages.h"
#include "tools/fleet/report_data.h"
#include "tools/report.h"

namespace cliquevo::tools::fleet {

namespace {

std::string configurations_text(const Plan& plan) {
  std::string out;
  for (const Configuration& c : plan.configurations) out += fmt::format("# {}\n{}\n", c.name, c.yaml);
  return out;
}

Result<void> write_report(const FleetResults& results, const nlohmann::json& report, const std::string& text) {
  const auto folder = drivers::OwnFolder::open(results.folder);
  if (!folder) return folder.error();
  if (auto ok = folder->write("report.json", text); !ok) return ok.error();
  const std::string name = std::filesystem::path(results.folder).filename().string();
  return folder->write("report.html", fleet_report(name, report, configurations_text(results.plan)));
}

int judge(const std::vector<FleetComparison>& comparisons, const Gates& gates) {
  for (const FleetComparison& c : comparisons) {
    if (!c.comparison.beyond_gate) continue;
    return tools::report({"worse than the gate", fmt::format("{} against {}", c.b, c.a),
                          fmt::format("--gate {} allows no more", gates.accuracy)},
                         kNotStrictEnough);
  }
  return kDone;
}

}  // namespace

int run_report_command(const ReportArguments& arguments) {
  std::error_code error;
  std::string folder = std::filesystem::absolute(arguments.out, error).lexically_normal().string();
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  const auto results = gather(folder);
  if (!results) return tools::report(results.error());
  const auto comparisons = compare_fleet(*results, arguments.baseline, arguments.gates);
  if (!comparisons) return tools::report(comparisons.error());
  const auto pages = make_pages(*results, static_cast<std::size_t>(arguments.pages));
  const nlohmann::json report = report_json(*results, *comparisons, arguments.gates, pages);
  const std::string text = report.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (auto ok = write_report(*results, report, text); !ok) return tools::report(ok.error());
  if (arguments.json) {
    fmt::print("{}", text);
  } else {
    fmt::print("{}page: {}/report.html\n", report_text(report), folder);
  }
  return judge(*comparisons, arguments.gates);
}

}  // namespace cliquevo::tools::fleet
