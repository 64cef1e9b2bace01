// SPDX-License-Identifier: BSD-3-Clause
// The metrics, judged by Prometheus' own promtool (of Debian's package, fetched once and not installed).
#include "tools/view/metrics.h"

#include <fstream>

#include <gtest/gtest.h>

#include "daemon/lcm/status_report.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::view {
namespace {

using test::Finished;
using test::run;

std::string promtool() {
  const Finished fetched = run({CLIQUEVO_UNPACKED_PACKAGE, "prometheus"});
  EXPECT_EQ(fetched.exit_code, 0) << fetched.err;
  return fetched.out.substr(0, fetched.out.find('\n')) + "/usr/bin/promtool";
}

Finished judged(const std::string& tool, const std::string& text) {
  const std::string path = test::scratch_dir() + "/metrics.prom";
  std::ofstream(path) << text;
  return run({"sh", "-c", "exec \"$1\" check metrics <\"$2\"", "sh", tool, path});
}

TEST(Metrics, PromtoolFindsNothingInThoseOfARunningAndOfASilentDaemon) {
  const std::string tool = promtool();
  health_t health{};
  health.state = health_t::RUNNING;
  health.pose_rate_hz = 29.5;
  FeedState state;
  state.health_json = daemon::status_json(health, "1.0");
  for (const char* text : {"live", "silent"}) {
    state.text = text;
    const Finished verdict = judged(tool, metrics_text(state, "0.2.0"));
    EXPECT_EQ(verdict.exit_code, 0) << verdict.out << verdict.err;
    EXPECT_EQ(verdict.out + verdict.err, "");
  }
  EXPECT_NE(judged(tool, "cliquevo_up one\n").exit_code, 0);  // it does look
}

}  // namespace
}  // namespace cliquevo::view
