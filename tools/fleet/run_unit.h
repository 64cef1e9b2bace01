// SPDX-License-Identifier: BSD-3-Clause
// What a node executes: units of a plan, one after the other, each in a process of its own.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "daemon/pipeline/cli_command.h"
#include "tools/fleet/plan.h"
#include "tools/fleet/store.h"

namespace cliquevo::tools::fleet {

inline constexpr const char* kFleetPurpose =
    "Many recordings times many configurations, on as many machines as there are";

struct UnitsEnd {
  std::size_t computed = 0;
  std::size_t found = 0;         // results that were there
  std::size_t failed = 0;        // reported, each with a line on stderr, and recorded
  std::optional<Error> stopped;  // interrupted, or a disk that takes nothing: the rest was not tried
};

// A unit that fails or crashes does not stop the others.
UnitsEnd run_units(const Plan& plan, const std::vector<std::size_t>& units, Store& store);

// fleet run-unit, as a sub-command of `fleet`.
void add_run_unit_command(CliCommand fleet, int& exit_code);

}  // namespace cliquevo::tools::fleet
