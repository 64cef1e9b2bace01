// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/metrics.h"

#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "daemon/lcm/status_report.h"

namespace cliquevo::view {
namespace {

FeedState running() {
  health_t health{};
  health.state = health_t::RUNNING;
  health.pose_rate_hz = 29.5;
  health.frames_dropped = 12;
  health.latency_p99_us = 12'500;
  FeedState out;
  out.text = "live";
  out.health_json = daemon::status_json(health, "1.0");
  return out;
}

TEST(Metrics, AreTheHealthMessageInBaseUnits) {
  const std::string text = metrics_text(running(), "0.2.0");
  for (const char* line : {"cliquevo_up 1\n", "cliquevo_pose_rate_hertz 29.5\n", "cliquevo_frames_dropped_total 12\n",
                           "cliquevo_latency_p99_seconds 0.0125\n", "cliquevo_state{state=\"running\"} 1\n",
                           "cliquevo_state{state=\"stalled\"} 0\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  }
}

TEST(Metrics, ASilentDaemonIsDownAndSaysNothingElse) {
  FeedState silent = running();
  silent.text = "silent";
  const std::string text = metrics_text(silent, "0.2.0");
  EXPECT_NE(text.find("cliquevo_up 0\n"), std::string::npos);
  EXPECT_EQ(text.find("cliquevo_pose_rate_hertz"), std::string::npos);
}

TEST(Metrics, EachHasHelpAndTypeOnceAndOnlyWellFormedSamples) {
  std::istringstream lines(metrics_text(running(), "0.2.0"));
  const std::regex sample(R"re((cliquevo_[a-z0-9_]+)(\{[a-z]+="[^"]*"\})? -?[0-9.e+-]+)re");
  std::set<std::string> named;
  std::string current;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# HELP ")) {
      current = line.substr(7, line.find(' ', 7) - 7);
      EXPECT_TRUE(named.insert(current).second) << line;
    } else if (line.starts_with("# TYPE ")) {
      EXPECT_TRUE(line.starts_with("# TYPE " + current + " ")) << line;
    } else {
      std::smatch parts;
      ASSERT_TRUE(std::regex_match(line, parts, sample)) << line;
      EXPECT_EQ(parts[1], current);
    }
  }
  EXPECT_GT(named.size(), 10U);
}

}  // namespace
}  // namespace cliquevo::view
