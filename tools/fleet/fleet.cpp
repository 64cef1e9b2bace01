// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/fleet.h"

#include <filesystem>
#include <map>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/time.h"
#include "drivers/own_folder.h"
#include "tools/exit_code.h"
#include "tools/fleet/engine.h"
#include "tools/fleet/make_plan.h"
#include "tools/fleet/progress_text.h"
#include "tools/fleet/report_command.h"
#include "tools/fleet/run_unit.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools::fleet {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kRunFile = "run.json";

struct FleetArguments {
  std::string out;
  PlanArgument plan;
  std::vector<std::pair<std::string, std::string>> reading;  // options that set a key of source.recording
  RunOptions run;
  std::string baseline;
  double gate = Gates{}.accuracy;
  bool json = false;
  bool follow = false;
};

// The plan with where it lies; the folder ours alone.
struct OpenPlan {
  std::string folder;  // absolute
  std::string file;    // absolute; does not change when the fleet is planned again
  Plan plan;
};

std::string absolute_folder(const std::string& path) {
  std::error_code error;
  std::string out = fs::absolute(path, error).lexically_normal().string();
  while (out.size() > 1 && out.back() == '/') out.pop_back();
  return out;
}

Result<std::string> build_of(const std::string& program) {
  const auto end = run_program({program, "fleet", "run-unit", "--build"});
  if (!end) return end.error();
  const std::string build = end->out.substr(0, end->out.find('\n'));
  if (end->exit_code == 0 && build.size() == 64) return build;
  return Error{"this program computes no units", program, "name one of this version: --program FILE"};
}

Result<OpenPlan> write_plan(FleetArguments& arguments) {
  PlanArgument& argument = arguments.plan;
  for (const auto& [key, value] : arguments.reading) {
    // A path may have commas, which else begin the next value of a sweep.
    const char* quote = key == "calibration" ? "'" : "";
    argument.settings.push_back(fmt::format("source.recording.{}={}{}{}", key, quote, value, quote));
  }
  OpenPlan out;
  out.folder = absolute_folder(arguments.out);
  const auto folder = drivers::OwnFolder::open(out.folder);
  if (!folder) return folder.error();
  const auto program = unit_program(argument.program);
  if (!program) return program.error();
  const auto build = build_of(*program);
  if (!build) return build.error();
  auto plan = make_plan(argument, *build);
  if (!plan) return plan.error();
  out.plan = std::move(*plan);
  out.plan.program = *program;
  out.plan.cache = argument.cache.empty() ? out.folder + "/results" : absolute_folder(argument.cache);
  const std::string text = plan_text(out.plan);
  const std::string name = plan_file_of(text);
  out.file = out.folder + "/" + name;
  if (auto ok = folder->write(name, text); !ok) return ok.error();
  if (auto ok = folder->write(kPlanFile, text); !ok) return ok.error();
  return out;
}

Result<OpenPlan> open_plan(const std::string& folder) {
  OpenPlan out;
  out.folder = absolute_folder(folder);
  auto plan = read_plan(out.folder + "/" + kPlanFile);
  if (!plan) return plan.error();
  out.plan = std::move(*plan);
  out.file = out.folder + "/" + plan_file_of(plan_text(out.plan));
  return out;
}

void tell_problems(const Plan& plan) {
  for (const Recording& r : plan.recordings) {
    if (!r.problem.empty()) warn({"left out", r.name, r.problem});
  }
}

std::string plan_sentence(const OpenPlan& open, std::size_t missing) {
  return fmt::format("{} units: {} recordings with {} configurations; {} to compute ({})\n", open.plan.units.size(),
                     open.plan.recordings.size(), open.plan.configurations.size(), missing, open.folder);
}

int run_plan(FleetArguments& arguments) {
  const auto open = write_plan(arguments);
  if (!open) return report(open.error());
  auto store = Store::open(open->plan.cache);
  if (!store) return report(store.error());
  tell_problems(open->plan);
  fmt::print("{}", plan_sentence(*open, missing_units(open->plan, *store).size()));
  return kDone;
}

// When it began, for status.
Result<void> note_run(const OpenPlan& open, const std::string& engine, const std::string& job) {
  const auto folder = drivers::OwnFolder::open(open.folder);
  if (!folder) return folder.error();
  const json text = {{"engine", engine}, {"job", job}, {"began_unix_ns", now_unix_ns()}};
  return folder->write(kRunFile, text.dump() + "\n");
}

int finish_local_run(const OpenPlan& open, Store& store, std::size_t tried) {
  const std::size_t missing = missing_units(open.plan, store).size();
  fmt::print("{} computed, {} of {} units have a result\n", tried - missing, open.plan.units.size() - missing,
             open.plan.units.size());
  if (missing == 0) return kDone;
  return report(
      {fmt::format("{} units have no result", missing), open.folder, "see the lines above, or cliquevo fleet report"});
}

std::vector<std::string> report_command(const FleetArguments& arguments, const OpenPlan& open) {
  std::error_code error;
  std::vector<std::string> out{fs::read_symlink("/proc/self/exe", error).string(), "fleet", "report", "--out",
                               open.folder};
  if (arguments.baseline.empty()) return out;
  const bool folder = fs::is_directory(arguments.baseline, error);
  out.insert(out.end(), {"--baseline", folder ? absolute_folder(arguments.baseline) : arguments.baseline, "--gate",
                         fmt::format("{}", arguments.gate)});
  return out;
}

int run_engine(FleetArguments& arguments, const OpenPlan& open, Store& store, const std::vector<std::size_t>& missing) {
  RunOptions& options = arguments.run;
  if (options.engine == Engine::print) {
    const auto each = static_cast<std::size_t>(std::max(1, options.units_per_task));
    for (const std::string& line : task_lines(open.plan, open.file, missing, each)) fmt::print("{}\n", line);
    return kDone;
  }
  if (auto room = store.probe(); !room) return report(room.error());
  if (options.engine == Engine::slurm) {
    options.report_command = report_command(arguments, open);
    const auto job = submit_to_slurm(open.plan, open.file, open.folder, missing, options);
    if (!job) return report(job.error());
    if (auto ok = note_run(open, "slurm", *job); !ok) return report(ok.error());
    fmt::print("Slurm job {}: {} units; cliquevo fleet status --out {}\n", *job, missing.size(), quoted(open.folder));
    return kDone;
  }
  if (auto ok = note_run(open, "local", ""); !ok) return report(ok.error());
  if (auto done = run_locally(open.plan, open.file, missing, options, store); !done) return report(done.error());
  return finish_local_run(open, store, missing.size());
}

int run_run(FleetArguments& arguments) {
  const auto open = arguments.plan.sources.empty() ? open_plan(arguments.out) : write_plan(arguments);
  if (!open) return report(open.error());
  auto store = Store::open(open->plan.cache);
  if (!store) return report(store.error());
  const std::vector<std::size_t> missing = missing_units(open->plan, *store);
  const bool print = arguments.run.engine == Engine::print;  // whose stdout is for the lines alone
  if (!arguments.plan.sources.empty()) tell_problems(open->plan);
  if (!print) fmt::print("{}", plan_sentence(*open, missing.size()));
  std::fflush(stdout);
  if (missing.empty()) return kDone;
  return run_engine(arguments, *open, *store, missing);
}

json standing_json(const Standing& s) {
  const auto or_null = [](const std::optional<double>& v) { return v ? json(*v) : json(nullptr); };
  return {{"units", s.units},
          {"done", s.done},
          {"failed", s.failed},
          {"waiting", s.waiting()},
          {"elapsed_s", s.elapsed_s},
          {"units_a_minute", or_null(s.units_a_minute())},
          {"left_s", or_null(s.left_s())}};
}

int run_status(const FleetArguments& arguments) {
  const auto open = open_plan(arguments.out);
  if (!open) return report(open.error());
  auto store = Store::open(open->plan.cache);
  if (!store) return report(store.error());
  const StopOnSignal signals;
  for (;;) {
    std::int64_t since_ns = 0;
    if (const auto folder = drivers::OwnFolder::open(open->folder)) {
      const json run = json::parse(folder->read(kRunFile, 4096).value_or(""), nullptr, false);
      if (run.is_object()) since_ns = run.value("began_unix_ns", std::int64_t{0});
    }
    const Standing standing = standing_of(open->plan, *store, since_ns, now_unix_ns());
    fmt::print("{}\n", arguments.json ? standing_json(standing).dump() : standing_text(standing));
    std::fflush(stdout);
    if (!arguments.follow || standing.waiting() == 0 || StopOnSignal::received()) return kDone;
    StopOnSignal::sleep_until(monotonic_ns() + 2'000'000'000);
  }
}

void add_plan_options(CliCommand command, FleetArguments& a, bool sources_required) {
  command.add_option("--out", a.out, "The fleet's folder: plan, results, report").required().type_name("DIR");
  const CliOption sources = command.add_option(
      "SOURCES", a.plan.sources,
      "Recordings: folders, logs, globs in quotes, folders of recordings, sim:..., or @FILE with one a line");
  if (sources_required) sources.required();
  command.add_option("--config", a.plan.configs, "A configuration; may be given again: each with every recording")
      .repeatable()
      .type_name("FILE");
  command
      .add_option("--set", a.plan.settings,
                  "Set one key, section.key=value; with several values, each of them in turn (a sweep); may be given "
                  "again: every combination")
      .repeatable()
      .type_name("KEY=VALUE,...");
  const auto sets = [&](const char* option, const char* key, const char* meaning, const char* type) {
    command
        .add_option_function<std::string>(
            option, [&a, key](const std::string& value) { a.reading.emplace_back(key, value); }, meaning)
        .type_name(type);
  };
  sets("--calibration", "calibration", "Calibration instead of the recordings' own", "FILE");
  sets("--rate", "rate_hz", "Pairs a second, whatever times are there", "HZ");
  sets("--first", "first", "First pair to play of each recording, counted from 0", "I");
  sets("--last", "last", "Last pair to play", "I");
  sets("--every", "every", "Play every K-th pair", "K");
  command.add_option("--cache", a.plan.cache, "Where results are kept (default: results in DIR); fleets may share it")
      .type_name("DIR");
  command.add_flag("--trajectories", a.plan.trajectories, "Keep each unit's trajectory too (KITTI format)");
  command.add_option("--program", a.plan.program, "The program that computes units, at this path on every machine")
      .type_name("FILE");
}

void add_gate_options(CliCommand command, FleetArguments& a) {
  command
      .add_option("--baseline", a.baseline,
                  "Hold against it, recording by recording: another fleet's folder, or one configuration's name")
      .type_name("DIR|NAME");
  command.add_option("--gate", a.gate, "So many times worse is allowed in each figure of accuracy, as of compare")
      .between(1.0, 1e6)
      .capture_default_str()
      .type_name("R");
}

void add_plan_command(CliCommand fleet, int& exit_code) {
  auto arguments = std::make_shared<FleetArguments>();
  const CliCommand command = fleet.add_subcommand("plan", "Recordings x configurations: what is to be computed");
  add_plan_options(command, *arguments, true);
  command.footer(
      "Exit codes: 0 planned; 1 no recording can be opened, a bad configuration; 2 wrong usage.\n"
      "Example: cliquevo fleet plan --out season '/data/2026-*' --set stereo.window=7,9 --config new.yaml");
  command.callback([arguments, &exit_code] { exit_code = run_plan(*arguments); });
}

void add_run_command(CliCommand fleet, int& exit_code) {
  auto arguments = std::make_shared<FleetArguments>();
  const CliCommand command = fleet.add_subcommand("run", "Compute what has no result yet; with SOURCES, plan it first");
  add_plan_options(command, *arguments, false);
  const std::map<std::string, Engine> engines{
      {"local", Engine::local}, {"slurm", Engine::slurm}, {"print", Engine::print}};
  command
      .add_option_function<std::string>(
          "--on", [arguments, engines](const std::string& name) { arguments->run.engine = engines.at(name); },
          "local (default): processes here; slurm: a job array, and the report after it; print: task lines for GNU "
          "parallel")
      .one_of({"local", "slurm", "print"})
      .type_name("ENGINE");
  command.add_option("-j,--jobs", arguments->run.processes, "local: processes at once (default: one a processor)")
      .between(1, 4096)
      .type_name("N");
  command.add_option("--throttle", arguments->run.throttle, "slurm: array elements at once (default: no limit)")
      .between(1, 1000000)
      .type_name("N");
  command.add_option("--units-per-task", arguments->run.units_per_task, "Units a task computes (default: chosen)")
      .between(1, 1000000)
      .type_name("N");
  command
      .add_option("--slurm", arguments->run.slurm_options,
                  "An option for sbatch, e.g. --slurm=--partition=night; may be given again")
      .repeatable()
      .type_name("OPTION");
  add_gate_options(command, *arguments);
  command.footer(
      "What has a result is not computed again: run again after whatever went wrong.\n"
      "Exit codes: 0 every unit has a result (slurm: submitted); 1 some have none, each with a line; 2 wrong usage.\n"
      "Examples:\n"
      "  cliquevo fleet run --out season '/data/2026-*' --set stereo.window=7,9\n"
      "  cliquevo fleet run --out season --on slurm --throttle 200\n"
      "  cliquevo fleet run --out season --on print | parallel");
  command.callback([arguments, &exit_code] { exit_code = run_run(*arguments); });
}

void add_status_command(CliCommand fleet, int& exit_code) {
  auto arguments = std::make_shared<FleetArguments>();
  const CliCommand command = fleet.add_subcommand("status", "How far it is: counts, rate, time left; from any machine");
  command.add_option("--out", arguments->out, "The fleet's folder").required().type_name("DIR");
  command.add_flag("--json", arguments->json, "Print JSON");
  command.add_flag("--follow", arguments->follow, "A line every two seconds until nothing waits");
  command.callback([arguments, &exit_code] { exit_code = run_status(*arguments); });
}

void add_report_command(CliCommand fleet, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  const CliCommand command =
      fleet.add_subcommand("report", "One page and JSON on all results: report.html, report.json in DIR");
  command.add_option("--out", arguments->out, "The fleet's folder").required().type_name("DIR");
  command
      .add_option("--baseline", arguments->baseline,
                  "Hold against it, recording by recording: another fleet's folder, or one configuration's name")
      .type_name("DIR|NAME");
  command.add_option("--gate", arguments->gates.accuracy, "So many times worse is allowed, as of compare")
      .between(1.0, 1e6)
      .capture_default_str()
      .type_name("R");
  command
      .add_option("--pages", arguments->pages,
                  "Replay so many runs, those with the worst frames, for a page each that the report links to")
      .between(0, 1000)
      .capture_default_str()
      .type_name("N");
  command.add_flag("--json", arguments->json, "Print the JSON instead of the summary");
  command.footer("Exit codes: 0 written; 1 no plan, a bad baseline; 2 wrong usage; 3 worse than the gate.");
  command.callback([arguments, &exit_code] { exit_code = run_report_command(*arguments); });
}

}  // namespace

void add_fleet_command(CliCommand app, int& exit_code) {
  const CliCommand fleet = app.add_subcommand("fleet", kFleetPurpose);
  fleet.require_subcommand();
  add_plan_command(fleet, exit_code);
  add_run_command(fleet, exit_code);
  add_status_command(fleet, exit_code);
  add_report_command(fleet, exit_code);
  add_run_unit_command(fleet, exit_code);
}

}  // namespace cliquevo::tools::fleet
