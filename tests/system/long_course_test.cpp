// SPDX-License-Identifier: BSD-3-Clause
// The bars on the reference scene over hundreds of metres: means over five noise seeds. Long: label bench.
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

constexpr int kSeeds = 5;
constexpr double kTimeoutS = 3600.0;

json stats_of(const std::string& source) {
  const std::string path = scratch_dir() + "/stats.json";
  const Finished done = Subprocess({binary("cliquevo"), "replay", source, "--strict", "--stats", path}).wait(kTimeoutS);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return json::parse(read_file(path));
}

void expect_a_tenth_of_a_percent(const std::string& course) {
  double end_pct = 0.0;
  double t_err_pct = 0.0;
  double r_err_deg_m = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const json stats = stats_of(fmt::format("sim:course={},frames=4000,noise_seed={}", course, seed));
    const json& reference = stats["reference"];
    EXPECT_EQ(stats["summary"]["frames"], 4000);
    EXPECT_NEAR(reference["path_m"].get<double>(), 400.0, 20.0);
    end_pct += reference["end_pct"].get<double>() / kSeeds;
    t_err_pct += reference["t_err_pct"].get<double>() / kSeeds;
    r_err_deg_m += reference["r_err_deg_m"].get<double>() / kSeeds;
    fmt::print("{} seed {}: end {:.3f} %, segments {:.3f} % {:.5f} deg/m\n", course, seed,
               reference["end_pct"].get<double>(), reference["t_err_pct"].get<double>(),
               reference["r_err_deg_m"].get<double>());
  }
  fmt::print("{}: mean end {:.3f} %, segments (10 to 100 m) {:.3f} % {:.5f} deg/m\n", course, end_pct, t_err_pct,
             r_err_deg_m);
  EXPECT_LE(end_pct, 0.1);
}

TEST(LongCourse, WheeledEndsWithinATenthOfAPercentAfter400Metres) { expect_a_tenth_of_a_percent("wheeled"); }

TEST(LongCourse, WalkingEndsWithinATenthOfAPercentAfter400Metres) { expect_a_tenth_of_a_percent("walking"); }

TEST(LongCourse, AStandingCameraDriftsLessThanTwoMillimetres) {
  double drift_m = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const json stats = stats_of(fmt::format("sim:course=standing,frames=300,noise_seed={}", seed));
    double most_m = 0.0;
    for (const json& frame : stats["frames"]) {
      most_m = std::max(most_m, frame["truth_error"]["translation_m"].get<double>());
    }
    fmt::print("standing seed {}: {:.2f} mm\n", seed, 1000.0 * most_m);
    drift_m += most_m / kSeeds;
  }
  EXPECT_LE(drift_m, 0.002);
}

}  // namespace
}  // namespace cliquevo::test
