// SPDX-License-Identifier: BSD-3-Clause
#include "tools/camera_run.h"

#include <gtest/gtest.h>

namespace cliquevo::tools {
namespace {

constexpr std::int64_t kPeriodNs = 100'000'000;

CameraRun run_of(double pace, int missing_every, std::int64_t skew_ns) {
  CameraRun run(10.0);
  for (int k = 0; k < 200; ++k) {
    if (missing_every > 0 && k % missing_every == 1) continue;
    run.add(static_cast<std::int64_t>(pace * static_cast<double>(k * kPeriodNs)), skew_ns, 5'000'000);
  }
  return run;
}

TEST(CameraRun, ACleanRunPassesWithItsFigures) {
  const CameraRun run = run_of(1.0, 0, 1'000'000);
  const auto verdict = run.judge();
  EXPECT_TRUE(verdict.complaints.empty());
  EXPECT_NEAR(verdict.rate_hz, 10.0, 1e-6);
  EXPECT_EQ(verdict.skipped, 0);
  EXPECT_NEAR(verdict.most_skew, 0.01, 1e-9);
  EXPECT_NEAR(verdict.most_delay_ms, 5.0, 1e-9);
  EXPECT_NE(run.histograms().find("199  ####"), std::string::npos) << run.histograms();
}

TEST(CameraRun, WrongRateMissingPairsAndCamerasApartAreEachNamed) {
  const auto complaint = [](const CameraRun& run) {
    const auto verdict = run.judge();
    return verdict.complaints.size() == 1 ? verdict.complaints[0] : std::to_string(verdict.complaints.size());
  };
  EXPECT_NE(complaint(run_of(1.06, 0, 0)).find("rate 9.4"), std::string::npos);
  EXPECT_NE(complaint(run_of(1.0, 20, 0)).find("gave no pair"), std::string::npos);
  EXPECT_NE(complaint(run_of(1.0, 0, 30'000'000)).find("0.30 periods apart"), std::string::npos);
  EXPECT_NE(complaint(CameraRun(10.0)).find("0 pairs"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::tools
