// SPDX-License-Identifier: BSD-3-Clause
#include "tools/comparison.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "tools/run_log.h"

namespace cliquevo::tools {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// How a figure is read, printed and judged. What is smaller than `floor` on both sides is as good as equal.
struct Kind {
  const char* name;
  const char* unit;
  int decimals;
  Gate gate;
  bool more_is_better;
  double floor;
  std::optional<double> (*of)(const RunFigures&);
};
constexpr Kind kKinds[] = {
    {"segments", "%", 4, Gate::accuracy, false, 0.005, [](const RunFigures& f) { return f.segments_pct; }},
    {"rotation", "deg/m", 5, Gate::accuracy, false, 0.0002, [](const RunFigures& f) { return f.rotation_deg_m; }},
    {"end", "%", 4, Gate::accuracy, false, 0.005, [](const RunFigures& f) { return f.end_pct; }},
    {"ATE", "m", 4, Gate::accuracy, false, 0.001, [](const RunFigures& f) { return f.ate_m; }},
    {"failed", "frames", 0, Gate::accuracy, false, 0.5, [](const RunFigures& f) { return std::optional(f.failed); }},
    {"skipped", "pairs", 0, Gate::accuracy, false, 0.5, [](const RunFigures& f) { return std::optional(f.skipped); }},
    {"quality", "of 100", 1, Gate::accuracy, true, 0.5, [](const RunFigures& f) { return f.quality; }},
    {"inliers", "median", 0, Gate::none, true, 0.5, [](const RunFigures& f) { return f.inliers; }},
    {"time", "ms", 2, Gate::time, false, 0.0, [](const RunFigures& f) { return f.time_ms; }},
    {"time 95 %", "ms", 2, Gate::time, false, 0.0, [](const RunFigures& f) { return f.time_p95_ms; }},
};

bool is_count(const Kind& kind) { return kind.decimals == 0 && kind.gate == Gate::accuracy; }

std::optional<double> number(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number() || !std::isfinite(found->get<double>())) return std::nullopt;
  return found->get<double>();
}

const json* member(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? &*found : nullptr;
}

std::optional<double> median_of_valid(const json& frames, const char* key) {
  std::vector<double> values;
  for (const json& frame : frames) {
    if (!frame.is_object() || number(frame, "status_code") != 1.0) continue;
    if (const auto value = number(frame, key)) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return spread_of(std::move(values)).median;
}

double times_worse(const Kind& kind, double a, double b) {
  if (std::max(std::abs(a), std::abs(b)) < kind.floor || a == b) return 1.0;
  const double good = std::max(kind.more_is_better ? b : a, is_count(kind) ? 0.0 : kind.floor);
  const double bad = std::max(kind.more_is_better ? a : b, is_count(kind) ? 0.0 : kind.floor);
  return good > 0.0 ? bad / good : std::numeric_limits<double>::infinity();
}

ComparedRun compare_figures(std::string name, const RunFigures& a, const RunFigures& b, const Gates& gates) {
  ComparedRun out;
  out.name = std::move(name);
  for (const Kind& kind : kKinds) {
    ComparedFigure figure{kind.name, kind.unit, kind.decimals, kind.gate, kind.of(a), kind.of(b), 1.0, false};
    if (!figure.a && !figure.b) continue;
    const double gate = kind.gate == Gate::accuracy ? gates.accuracy
                        : kind.gate == Gate::time   ? gates.time.value_or(std::numeric_limits<double>::infinity())
                                                    : std::numeric_limits<double>::infinity();
    if (figure.a && figure.b) {
      figure.times_worse = times_worse(kind, *figure.a, *figure.b);
      figure.beyond_gate = figure.times_worse > gate;
    } else if (figure.a && kind.gate == Gate::accuracy) {  // the second run has not even a figure
      figure.times_worse = std::numeric_limits<double>::infinity();
      figure.beyond_gate = true;
    }
    out.beyond_gate = out.beyond_gate || figure.beyond_gate;
    out.figures.push_back(figure);
  }
  return out;
}

// Of runs that both sides have; a mean of what all of them have.
RunFigures summed(const std::vector<const RunFigures*>& runs) {
  RunFigures out;
  const auto mean = [&runs](std::optional<double> RunFigures::*field) {
    double sum = 0.0;
    for (const RunFigures* run : runs) {
      if (!(run->*field)) return std::optional<double>();
      sum += *(run->*field);
    }
    return runs.empty() ? std::optional<double>() : std::optional(sum / static_cast<double>(runs.size()));
  };
  for (const RunFigures* run : runs) {
    out.frames += run->frames;
    out.failed += run->failed;
    out.skipped += run->skipped;
  }
  for (const auto field :
       {&RunFigures::segments_pct, &RunFigures::rotation_deg_m, &RunFigures::end_pct, &RunFigures::ate_m,
        &RunFigures::quality, &RunFigures::inliers, &RunFigures::time_ms, &RunFigures::time_p95_ms}) {
    out.*field = mean(field);
  }
  return out;
}

Result<std::string> read_text(const fs::path& path) {
  std::error_code failed;
  std::ifstream file(path, std::ios::binary);
  if (!fs::is_regular_file(path, failed) || !file) {
    return Error{"cannot read statistics", path.string(), "name a file that replay --stats wrote, or a folder of them"};
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::string number_text(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

std::string change_text(const ComparedFigure& f) {
  if (!f.a || !f.b) return "-";
  if (!std::isfinite(f.times_worse)) return "worse";
  return fmt::format("x {:.2f}", f.times_worse);
}

std::string rows_of(const ComparedRun& run) {
  if (!run.missing_in.empty()) return fmt::format("{}: missing in {}\n", printable(run.name), run.missing_in);
  std::string out = fmt::format("{}\n", printable(run.name));
  for (const ComparedFigure& f : run.figures) {
    out += fmt::format("  {:<10} {:>12} {:>12}  {:<7} {:>8}{}\n", f.name, number_text(f.a, f.decimals),
                       number_text(f.b, f.decimals), f.unit, change_text(f), f.beyond_gate ? "  beyond the gate" : "");
  }
  return out;
}

json run_json(const ComparedRun& run) {
  json out = {{"name", run.name}, {"beyond_gate", run.beyond_gate}, {"figures", json::array()}};
  if (!run.missing_in.empty()) out["missing_in"] = run.missing_in;
  const auto or_null = [](const std::optional<double>& v) { return v ? json(*v) : json(nullptr); };
  for (const ComparedFigure& f : run.figures) {
    out["figures"].push_back({{"name", f.name},
                              {"unit", f.unit},
                              {"a", or_null(f.a)},
                              {"b", or_null(f.b)},
                              {"times_worse", std::isfinite(f.times_worse) ? json(f.times_worse) : json(nullptr)},
                              {"beyond_gate", f.beyond_gate}});
  }
  return out;
}

}  // namespace

Result<RunFigures> parse_run(const std::string& text, const std::string& where) {
  const json stats = json::parse(text, nullptr, false);
  const json* summary = stats.is_object() ? member(stats, "summary") : nullptr;
  const auto frames = stats.is_object() ? stats.find("frames") : stats.end();
  if (summary == nullptr || frames == stats.end() || !frames->is_array() || !number(*summary, "frames") ||
      !number(*summary, "failed")) {
    return Error{"no statistics of a run", where, "name a file that replay --stats wrote, or a folder of them"};
  }
  RunFigures out;
  out.frames = *number(*summary, "frames");
  out.failed = *number(*summary, "failed");
  out.skipped = number(*summary, "skipped").value_or(0.0);
  if (const json* reference = member(stats, "reference")) {
    out.segments_pct = number(*reference, "t_err_pct");
    out.rotation_deg_m = number(*reference, "r_err_deg_m");
    out.end_pct = number(*reference, "end_pct");
    out.ate_m = number(*reference, "ate_m");
  }
  out.quality = median_of_valid(*frames, "quality");
  out.inliers = median_of_valid(*frames, "inliers");
  const json* times = member(*summary, "times_ms");
  if (const json* total = times != nullptr ? member(*times, "total") : nullptr) {
    out.time_ms = number(*total, "median");
    out.time_p95_ms = number(*total, "p95");
  }
  return out;
}

Result<std::vector<NamedRun>> read_runs(const std::string& path) {
  std::vector<fs::path> files;
  std::error_code failed;
  const bool folder = fs::is_directory(path, failed);
  if (folder) {
    for (fs::directory_iterator entry(path, failed), end; !failed && entry != end; entry.increment(failed)) {
      if (entry->path().extension() == ".json") files.push_back(entry->path());
    }
    if (files.empty()) return Error{"no statistics in the folder", path, "put files of replay --stats there: *.json"};
    std::sort(files.begin(), files.end());
  } else {
    files.emplace_back(path);
  }
  std::vector<NamedRun> out;
  for (const fs::path& file : files) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto run = parse_run(*text, file.string());
    if (!run) return run.error();
    out.push_back({file.stem().string(), *run});
  }
  return out;
}

Comparison compare_runs(const std::vector<NamedRun>& a, const std::vector<NamedRun>& b, const Gates& gates) {
  Comparison out;
  std::vector<const RunFigures*> of_a;
  std::vector<const RunFigures*> of_b;
  const bool single = a.size() == 1 && b.size() == 1;
  const auto missing = [&out](const std::string& name, const char* side) {
    out.runs.push_back({name, side, {}, *side == 'B'});  // what the second does not have is as bad as failed
  };
  for (const NamedRun& run : a) {
    const auto other =
        std::find_if(b.begin(), b.end(), [&](const NamedRun& r) { return single || r.name == run.name; });
    if (other == b.end()) {
      missing(run.name, "B");
      continue;
    }
    const std::string name = single && other->name != run.name ? run.name + " / " + other->name : run.name;
    out.runs.push_back(compare_figures(name, run.figures, other->figures, gates));
    of_a.push_back(&run.figures);
    of_b.push_back(&other->figures);
  }
  for (const NamedRun& run : b) {
    const auto same = [&run](const NamedRun& r) { return r.name == run.name; };
    if (!single && std::none_of(a.begin(), a.end(), same)) missing(run.name, "A");
  }
  out.in_all = compare_figures("in all", summed(of_a), summed(of_b), gates);
  out.beyond_gate = out.in_all.beyond_gate;
  for (const ComparedRun& run : out.runs) out.beyond_gate = out.beyond_gate || run.beyond_gate;
  return out;
}

std::string comparison_table(const Comparison& comparison) {
  std::string out = fmt::format("{:<12} {:>12} {:>12}  {:<7} {:>8}\n", "", "A", "B", "", "worse by");
  for (const ComparedRun& run : comparison.runs) out += rows_of(run);
  if (comparison.runs.size() > 1) out += rows_of(comparison.in_all);
  return out;
}

json comparison_json(const Comparison& comparison, const Gates& gates) {
  json out = {{"gate", gates.accuracy},
              {"time_gate", gates.time ? json(*gates.time) : json(nullptr)},
              {"beyond_gate", comparison.beyond_gate},
              {"runs", json::array()},
              {"in_all", run_json(comparison.in_all)}};
  for (const ComparedRun& run : comparison.runs) out["runs"].push_back(run_json(run));
  return out;
}

}  // namespace cliquevo::tools
