// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/run_unit.h"

#include <memory>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "tools/exit_code.h"
#include "tools/fleet/digest.h"
#include "tools/fleet/isolated.h"
#include "tools/fleet/unit.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools::fleet {

namespace {

using nlohmann::json;

std::string host_name() {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  return host;
}

// Which unit of the plan it was, before what went wrong.
Error of_unit(const Plan& plan, std::size_t number, const Error& error) {
  return {error.what, fmt::format("unit {}, {}, {}", number, plan.unit_name(plan.units[number]), error.where),
          error.remedy};
}

Result<void> record_failure(Store& store, const std::string& key, const Error& error, const std::string& said) {
  const json text = {{"what", error.what},
                     {"where", error.where},
                     {"remedy", error.remedy},
                     {"said", printable(said)},
                     {"host", host_name()}};
  return store.write(key, Part::failure, text.dump(-1, ' ', false, json::error_handler_t::replace) + "\n");
}

// The result last: where it is, all the rest is.
Result<void> put(Store& store, const Plan& plan, const std::string& key, const UnitTexts& texts) {
  if (plan.trajectories) {
    if (auto ok = store.write_trajectory(key, texts.trajectory); !ok) return ok.error();
  }
  if (auto ok = store.write(key, Part::cost, texts.cost); !ok) return ok.error();
  return store.write(key, Part::result, texts.result);
}

// The last line that a crashed unit printed says most.
Error with_last_words(Error error, const std::string& said) {
  const std::size_t end = said.find_last_not_of("\n ");
  if (end == std::string::npos) return error;
  const std::size_t begin = said.find_last_of('\n', end);
  const std::string last = said.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
  error.remedy += fmt::format(" (its last line: {})", printable(std::string_view(last).substr(0, 200)));
  return error;
}

IsolatedEnd run_one(const Plan& plan, const Unit& unit, Store& store) {
  const std::string& source = plan.recording_of(unit).source;
  const Error crash{"the unit crashed", source,
                    fmt::format("replay it alone to see why: cliquevo replay '{}'", source)};
  IsolatedEnd end = run_isolated(
      [&]() -> Result<void> {
        const auto texts = compute_unit(plan, unit);
        if (!texts) return texts.error();
        return put(store, plan, unit.key, *texts);
      },
      crash);
  if (end.crashed) end.error = with_last_words(*end.error, end.said);
  return end;
}

const Error kInterrupted{"interrupted", "fleet run-unit", "run again: what is computed is kept"};

// Nothing of such a plan is computed here: the results would stand under another build's keys.
std::optional<Error> other_build(const Plan& plan) {
  if (plan.build == build_digest()) return std::nullopt;
  return Error{"another build of cliquevo, or of a library, than the plan's", host_name(),
               "install the same packages on every machine, or plan again"};
}

}  // namespace

UnitsEnd run_units(const Plan& plan, const std::vector<std::size_t>& units, Store& store) {
  const StopOnSignal signals;
  const auto refused = other_build(plan);
  if (refused) report(*refused);
  UnitsEnd out;
  for (const std::size_t number : units) {
    const Unit& unit = plan.units[number];
    if (store.read(unit.key, Part::result)) {
      ++out.found;
      continue;
    }
    IsolatedEnd end;
    if (refused) {
      end.error = refused;
    } else {
      end = run_one(plan, unit, store);
    }
    if (StopOnSignal::received()) {
      out.stopped = kInterrupted;
      return out;
    }
    if (!end.error) {
      ++out.computed;
      store.forget(unit.key, Part::failure);
      continue;
    }
    ++out.failed;
    const Error error = of_unit(plan, number, *end.error);
    const auto recorded = record_failure(store, unit.key, error, end.said);
    if (recorded && !refused) report(error);  // a disk that takes nothing is one line, not one a unit
    const auto room = recorded ? store.probe() : recorded;
    if (!room) {
      out.stopped = room.error();
      return out;
    }
  }
  return out;
}

namespace {

struct RunUnitArguments {
  std::string plan;
  std::string units;
  bool build = false;
  bool watched = false;
};

int run(const RunUnitArguments& arguments) {
  if (arguments.build) {
    fmt::print("{}\n", build_digest());
    return kDone;
  }
  if (arguments.plan.empty() || arguments.units.empty()) {
    return report({"wrong usage", "cliquevo fleet run-unit", "give --plan and --units, or --build"}, kWrongUsage);
  }
  build_digest();  // before anything else is loaded
  const auto plan = read_plan(arguments.plan);
  if (!plan) return report(plan.error());
  const auto units = parse_units(arguments.units, plan->units.size());
  if (!units) return report(units.error());
  auto store = Store::open(plan->cache);
  if (!store) return report(store.error());
  const UnitsEnd end = run_units(*plan, *units, *store);
  fmt::print("{} computed, {} there already, {} failed\n", end.computed, end.found, end.failed);
  if (end.stopped && arguments.watched) return kBadInput;
  if (end.stopped) return report(*end.stopped);
  return end.failed == 0 ? kDone : kBadInput;
}

}  // namespace

void add_run_unit_command(CliCommand fleet, int& exit_code) {
  auto arguments = std::make_shared<RunUnitArguments>();
  const CliCommand command =
      fleet.add_subcommand("run-unit", "Compute units of a plan on this machine: what fleet run starts");
  // Where `fleet` itself is handed over to another program, that must not be inherited.
  command.pass_on_nothing();
  command.add_option("--plan", arguments->plan, "The plan's file").type_name("FILE");
  command.add_option("--units", arguments->units, "Their numbers in it, from 0: 0-9,12").type_name("LIST");
  command.add_flag("--watched", arguments->watched, "Who started it says what stopped it: a full disk, Ctrl-C");
  command.add_flag("--build", arguments->build, "Print the hash of this program and its libraries, and end");
  command.footer(
      "Needs no drawing. Exit codes: 0 every unit has its result; 1 one failed, each with a line on stderr, or "
      "another\n"
      "build than the plan's; 2 wrong usage.");
  command.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools::fleet
