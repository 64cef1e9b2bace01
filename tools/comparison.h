// SPDX-License-Identifier: BSD-3-Clause
// Two sets of runs side by side, from what `replay --stats` wrote: how right, how often, how fast; and whether the
// second is worse than is allowed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"

namespace cliquevo::tools {

// What of a run is compared. Absent: the run had no reference, or no valid frame.
struct RunFigures {
  double frames = 0.0;
  double failed = 0.0;   // frames
  double skipped = 0.0;  // pairs
  std::optional<double> segments_pct;
  std::optional<double> rotation_deg_m;
  std::optional<double> end_pct;
  std::optional<double> ate_m;
  std::optional<double> quality;  // median of the valid frames, 0 to 100
  std::optional<double> inliers;  // median of the valid frames
  std::optional<double> time_ms;  // a frame, median
  std::optional<double> time_p95_ms;
};

struct NamedRun {
  std::string name;
  RunFigures figures;
};

enum class Gate { accuracy, time, none };

// One figure of both sides.
struct ComparedFigure {
  const char* name = "";
  const char* unit = "";
  int decimals = 0;
  Gate gate = Gate::none;
  std::optional<double> a;
  std::optional<double> b;
  double times_worse = 1.0;  // 1 = as good; below = better; infinite where nothing stands beside something
  bool beyond_gate = false;
};

struct ComparedRun {
  std::string name;
  std::string missing_in;  // "A", "B" or empty
  std::vector<ComparedFigure> figures;
  bool beyond_gate = false;
};

struct Gates {
  double accuracy = 1.10;      // so many times worse is allowed
  std::optional<double> time;  // none: times are printed, not judged
};

struct Comparison {
  std::vector<ComparedRun> runs;
  ComparedRun in_all;  // means, of failed and skipped the sums, over the runs that both sides have
  bool beyond_gate = false;
};

// A stats file, or a folder of them (each *.json; the name is the file's without the ending).
Result<std::vector<NamedRun>> read_runs(const std::string& path);
// The text of one stats file; `where` is for the message.
Result<RunFigures> parse_run(const std::string& text, const std::string& where);

// Two single files belong together whatever their names; files of folders by name.
Comparison compare_runs(const std::vector<NamedRun>& a, const std::vector<NamedRun>& b, const Gates& gates);

std::string comparison_table(const Comparison& comparison);
nlohmann::json comparison_json(const Comparison& comparison, const Gates& gates);

}  // namespace cliquevo::tools
