// SPDX-License-Identifier: BSD-3-Clause
// What a fleet computes: recordings times configurations, each a unit with a key. As data, and as a file that every
// machine reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::tools::fleet {

struct Recording {
  std::string name;         // short, and no other's
  std::string source;       // absolute path, or sim:...
  std::int64_t frames = 0;  // pairs to play; -1 = not known
  std::int64_t bytes = 0;   // on disk
  std::string problem;      // the one line of why it cannot be opened; empty = it can, and has units
};

struct Configuration {
  std::string name;  // of its file, and what the sweep has set
  std::string yaml;  // every key in force
};

struct Unit {
  std::string key;  // equal keys have equal results
  std::size_t recording = 0;
  std::size_t configuration = 0;
};

struct Plan {
  std::string build;    // digest.h; of the program below
  std::string version;  // of cliquevo
  std::string program;  // computes the units: its path is the same on every machine
  std::string cache;    // folder of the results, absolute
  bool trajectories = false;
  std::vector<Recording> recordings;
  std::vector<Configuration> configurations;
  std::vector<Unit> units;

  const Recording& recording_of(const Unit& unit) const { return recordings[unit.recording]; }
  const Configuration& configuration_of(const Unit& unit) const { return configurations[unit.configuration]; }
  // "drive_07 with default", for messages.
  std::string unit_name(const Unit& unit) const;
};

// The plan in force in a fleet's folder, and the copy under its own name that tasks refer to: a later plan does not
// change what they compute.
inline constexpr const char* kPlanFile = "plan.json";
std::string plan_file_of(const std::string& text);  // "plan-0123456789ab.json"

std::string plan_text(const Plan& plan);
// where: for messages.
Result<Plan> parse_plan(const std::string& text, const std::string& where);
// Errors: none there, written by another user or writable by others, no plan.
Result<Plan> read_plan(const std::string& path);

// Positions of units as text: "0-9,12". Error: no such list, or one that goes beyond `count` units.
Result<std::vector<std::size_t>> parse_units(const std::string& text, std::size_t count);
std::string units_text(const std::vector<std::size_t>& units);

}  // namespace cliquevo::tools::fleet
