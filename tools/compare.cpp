// SPDX-License-Identifier: BSD-3-Clause
// cliquevo compare: is this build worse than that one?
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/commands.h"
#include "tools/comparison.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"

namespace cliquevo::tools {

namespace {

struct CompareArguments {
  std::string a;
  std::string b;
  Gates gates;
  bool json = false;
  std::string out;
  std::string report;
};

int run(const CompareArguments& arguments) {
  const Drawing* drawing = nullptr;
  if (!arguments.report.empty()) {
    auto found = find_drawing("compare --report");
    if (!found) return report(found.error());
    drawing = *found;
  }
  const auto a = read_runs(arguments.a);
  if (!a) return report(a.error());
  const auto b = read_runs(arguments.b);
  if (!b) return report(b.error());
  const Comparison comparison = compare_runs(*a, *b, arguments.gates);
  const auto both_have = [](const ComparedRun& run) { return run.missing_in.empty(); };
  if (std::none_of(comparison.runs.begin(), comparison.runs.end(), both_have)) {
    return report({"nothing to compare", arguments.a + ", " + arguments.b, "name runs of the same sequences"});
  }
  const std::string text =
      comparison_json(comparison, arguments.gates).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (!arguments.out.empty()) {
    auto file = OutputFile::open(arguments.out, "comparison");
    if (!file) return report(file.error());
    if (auto ok = file->write(text); !ok) return report(ok.error());
  }
  if (!arguments.report.empty()) {
    auto file = OutputFile::open(arguments.report, "report");
    if (!file) return report(file.error());
    const std::string page =
        drawing->comparison_report(arguments.a + " and " + arguments.b, comparison_json(comparison, arguments.gates));
    if (auto ok = file->write(page); !ok) return report(ok.error());
  }
  fmt::print("{}", arguments.json ? text : comparison_table(comparison));
  if (!comparison.beyond_gate) return kDone;
  for (const ComparedRun& run : comparison.runs) {
    if (!run.beyond_gate) continue;
    return report(
        {"B is worse than the gate", run.name, fmt::format("--gate {} allows no more", arguments.gates.accuracy)},
        kNotStrictEnough);
  }
  return report(
      {"B is worse than the gate", "in all", fmt::format("--gate {} allows no more", arguments.gates.accuracy)},
      kNotStrictEnough);
}

}  // namespace

void add_compare_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  const CliCommand compare =
      app.add_subcommand("compare", "Two runs, or two folders of runs, side by side: is B worse than A?");
  compare.add_option("A", arguments->a, "Statistics that replay --stats wrote, or a folder of such files").required();
  compare.add_option("B", arguments->b, "The same of what is judged; files of folders belong together by name")
      .required();
  compare.add_option("--gate", arguments->gates.accuracy, "B may be so many times worse in each figure of accuracy")
      .between(1.0, 1e6)
      .capture_default_str()
      .type_name("R");
  compare
      .add_option_function<double>(
          "--time-gate", [arguments](const double& gate) { arguments->gates.time = gate; },
          "The same of times, which else are listed and not judged: another program may have run beside")
      .between(1.0, 1e6)
      .type_name("R");
  compare.add_flag("--json", arguments->json, "Print JSON instead of the table");
  compare.add_option("--out", arguments->out, "Write the JSON into a file as well").type_name("FILE.json");
  compare.add_option("--report", arguments->report, "Write the tables as a page into one file").type_name("FILE.html");
  compare.footer(
      "Judged are segments, rotation, end and ATE (against the reference), failed frames, skipped pairs and quality, "
      "of\n"
      "each sequence and in all. Exit codes: 0 not worse; 1 bad input; 2 wrong usage; 3 worse than the gate.\n"
      "Examples:\n"
      "  cliquevo replay sim --stats a.json; cliquevo replay sim --config new.yaml --stats b.json\n"
      "  cliquevo compare a.json b.json --gate 1.05\n"
      "  cliquevo compare runs/release runs/mine --json");
  compare.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
