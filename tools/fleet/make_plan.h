// SPDX-License-Identifier: BSD-3-Clause
// From a command line to a plan: what recordings there are, what configurations the sweeps make, and the key of each
// unit.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "tools/fleet/plan.h"

namespace cliquevo::tools::fleet {

struct PlanArgument {
  std::vector<std::string> sources;   // folders, globs, files, sim:..., @FILE with a source a line
  std::vector<std::string> configs;   // files; none: the defaults
  std::vector<std::string> settings;  // key=value, or key=value,value,...: each of them in turn
  std::string cache;                  // empty = results/ in the fleet's folder
  std::string program;                // that computes units; empty = the one beside this
  bool trajectories = false;
};

// A configuration with what the sweep has set of it, read and ready.
struct ReadConfiguration {
  std::string name;
  daemon::Config config;
};

// "key=a,b" as {"key=a", "key=b"}; commas within brackets and quotes belong to a value. Error: no "=", or an empty
// value.
Result<std::vector<std::string>> sweep_values(const std::string& setting);
// Each file with each combination of the settings' values.
Result<std::vector<ReadConfiguration>> read_configurations(const PlanArgument& argument);

// Folders, files and sim:... that the sources mean, absolute, each once. A folder that is no recording stands for those
// in it. Error: there is none.
Result<std::vector<std::string>> find_sources(const std::vector<std::string>& sources);
// Short names, no two alike: as much of the paths' ends as it takes.
std::vector<std::string> short_names(const std::vector<std::string>& sources);

// The program that computes units: beside this one as built or as installed. Error: not there.
Result<std::string> unit_program(const std::string& asked);

// Opens every recording once a way of reading it. build: of the program that computes the units (digest.h). One
// that cannot be opened is in the plan with its problem. Errors: a configuration that cannot be read, no recording at
// all.
Result<Plan> make_plan(const PlanArgument& argument, const std::string& build);

}  // namespace cliquevo::tools::fleet
