// SPDX-License-Identifier: BSD-3-Clause
// How the units of a plan get onto processors: task lines, each a command that computes some units, and who runs them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/fleet/plan.h"
#include "tools/fleet/store.h"

namespace cliquevo::tools::fleet {

enum class Engine { local, slurm, print };

struct RunOptions {
  Engine engine = Engine::local;
  int processes = 0;                        // local: at once; 0 = one a processor
  int throttle = 0;                         // Slurm: array elements at once; 0 = as many as there is room for
  int units_per_task = 0;                   // 0 = chosen by the engine
  std::vector<std::string> slurm_options;   // passed on to sbatch
  std::vector<std::string> report_command;  // that Slurm runs after the last unit
};

// Units without a result, in the plan's order; of equal keys one.
std::vector<std::size_t> missing_units(const Plan& plan, Store& store);

// A word as sh reads it back.
std::string quoted(const std::string& word);
// One command a line, for sh. plan_file: absolute.
std::vector<std::string> task_lines(const Plan& plan, const std::string& plan_file,
                                    const std::vector<std::size_t>& units, std::size_t units_per_task);

// Runs them on this machine. Shows progress on stderr, and each failed unit's line as it comes. Error: interrupted, the
// disk is full, the program cannot be run; not that units failed, which the store says.
Result<void> run_locally(const Plan& plan, const std::string& plan_file, const std::vector<std::size_t>& units,
                         const RunOptions& options, Store& store);

// Hands them to Slurm as a job array, and the report as a job after it. Error: no Slurm here, or it refuses; its own
// words are in it. Value: the job's number.
Result<std::string> submit_to_slurm(const Plan& plan, const std::string& plan_file, const std::string& fleet_folder,
                                    const std::vector<std::size_t>& units, const RunOptions& options);

// What a program printed and how it ended. Error: it cannot be run.
struct ProgramEnd {
  int exit_code = -1;  // 128 + signal when one ended it
  std::string out;
  std::string err;
};
Result<ProgramEnd> run_program(const std::vector<std::string>& words);

}  // namespace cliquevo::tools::fleet
