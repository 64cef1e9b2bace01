// SPDX-License-Identifier: BSD-3-Clause
// A thousand units of twenty frames: what a unit costs beside its replay, and how long the report takes. Prints both.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <thread>

#include "tests/system/fleet_rig.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

constexpr int kRecordings = 500;
constexpr double kMostOverheadS = 0.050;
constexpr double kMostReportS = 20.0;

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

TEST(FleetOfAThousand, CostsLittleBesideTheReplaysAndItsReportIsQuick) {
  const std::string folder = scratch_dir() + "/fleet";
  std::vector<std::string> words = small_courses(kRecordings);
  words.insert(words.end(), {"--set", "stereo.window=7,9"});
  const double plan_s = seconds_of([&] { ASSERT_EQ(fleet("plan", folder, words).exit_code, 0); });
  Finished done;
  const double run_s = seconds_of([&] {
    // The subprocess's usual patience is too short for a thousand units.
    done = Subprocess({binary("cliquevo"), "fleet", "run", "--out", folder}).wait(3000.0);
  });
  ASSERT_EQ(done.exit_code, 0) << done.err;
  double replays_s = 0.0;
  int units = 0;
  for (const auto& [name, text] : files_ending(folder, ".cost.json")) {
    const json cost = json::parse(text.substr(text.find('\n') + 1));
    replays_s += cost["replay_s"].get<double>();
    ++units;
  }
  ASSERT_EQ(units, 2 * kRecordings);
  const double processes = std::max(1U, std::thread::hardware_concurrency());
  const double overhead_s = (run_s * processes - replays_s) / units;
  const double report_s = seconds_of([&] { ASSERT_EQ(fleet("report", folder).exit_code, 0); });
  std::printf(
      "plan %.2f s; %d units in %.1f s on %.0f processes; replay %.1f ms a unit, beside it %.1f ms; report %.2f s\n",
      plan_s, units, run_s, processes, 1e3 * replays_s / units, 1e3 * overhead_s, report_s);
  EXPECT_LE(overhead_s, kMostOverheadS);
  EXPECT_LE(report_s, kMostReportS);
}

}  // namespace
}  // namespace cliquevo::test
