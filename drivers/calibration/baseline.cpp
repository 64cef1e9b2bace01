// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/baseline.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace cliquevo::drivers {

namespace {

// Rigs that vehicles carry are well inside; whoever has another says so by its unit.
constexpr double kLeastBaseline_m = 0.004;
constexpr double kMostBaseline_m = 2.0;
// No rig, whatever the unit.
constexpr double kLeastPossible_m = 1e-4;
constexpr double kMostPossible_m = 50.0;
// Between the bounds, where images are seen: a wide rig that sees nothing near.
constexpr double kWide_m = 0.8;
constexpr double kFarAway_m = 15.0;
constexpr double kUnusual_m = 0.95;  // squares of a board and other units begin here

struct Unit {
  double metres;
  const char* name;
};
constexpr std::array<Unit, 6> kUnits{{{0.001, "in millimetres"},
                                      {0.01, "in centimetres"},
                                      {0.025, "in squares of 25 mm"},
                                      {0.0254, "in inches"},
                                      {1000.0, "divided by 1000"},
                                      {100.0, "divided by 100"}}};

// "0.1103 m if in squares of 25 mm (--baseline-unit 0.025)", for each unit that makes a usual rig of it.
std::string readings(double baseline) {
  std::string out;
  for (const Unit& unit : kUnits) {
    const double metres = baseline * unit.metres;
    if (metres < 0.015 || metres > 0.8) continue;
    out +=
        fmt::format("{}{:.4f} m if {} (--baseline-unit {:g})", out.empty() ? "" : ", ", metres, unit.name, unit.metres);
  }
  return out;
}

}  // namespace

Result<void> check_baseline(double baseline_m, bool named, const std::string& where) {
  if (!(baseline_m >= 1e-9)) return Error{"baseline is zero", where, "name the right calibration file"};
  if (named ? baseline_m >= kLeastPossible_m && baseline_m <= kMostPossible_m
            : baseline_m >= kLeastBaseline_m && baseline_m <= kMostBaseline_m) {
    return {};
  }
  std::string remedy = named ? "" : readings(baseline_m);
  if (remedy.empty()) {
    remedy = "calibrate the cameras again, or give metres a unit with --baseline-unit (baseline_unit)";
  } else {
    remedy =
        fmt::format("it would be {}; --baseline-unit 1 if it is in metres (in a configuration: baseline_unit)", remedy);
  }
  return Error{fmt::format("baseline of {:.4g} m is implausible", baseline_m), where, remedy};
}

std::optional<std::string> note_wide_baseline(double baseline_m) {
  if (baseline_m < kUnusual_m) return std::nullopt;
  return fmt::format("baseline is read as {:.4g} m, as nothing in the file names a unit; {}", baseline_m,
                     readings(baseline_m));
}

std::optional<std::string> doubt_baseline(double baseline_m, double near_m) {
  if (baseline_m < kWide_m || near_m < kFarAway_m) return std::nullopt;
  return fmt::format("baseline of {:.4g} m: nothing is nearer than {:.0f} m then; {}", baseline_m, near_m,
                     readings(baseline_m));
}

}  // namespace cliquevo::drivers
