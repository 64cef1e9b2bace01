// SPDX-License-Identifier: BSD-3-Clause
// VO_POINTS of the real daemon over real multicast: at its rate, in the body's frame, beside poses that lack none; and
// as `cliquevo echo` shows it.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int kFrames = 60;

// The simulator's camera on its body, at the pace of 30 Hz.
std::string write_config(const std::string& more, const std::string& loop = "none") {
  const std::string path = scratch_dir() + "/config.yaml";
  std::ofstream(path) << "source: {type: simulator, loop: " << loop << ", simulator: {width: 256, height: 192, "
                      << "focal_px: 280, frames: " << kFrames << ", cache_dir: none}}\nstereo: {num_disparities: 48}\n"
                      << "body: {translation_m: [0, 0, 0.85], roll_pitch_yaw_deg: [0, 13, 0]}\n"
                      << "lcm: {url: \"" << kUrl << "\", points_channel: VO_POINTS" << more << "}\n";
  return path;
}

struct Collector {
  std::string log;  // of the daemon
  std::vector<points_t> points;
  std::vector<std::int64_t> poses;  // utime
  void on_points(const lcm::ReceiveBuffer*, const std::string&, const points_t* m) { points.push_back(*m); }
  void on_odometry(const lcm::ReceiveBuffer*, const std::string&, const odometry_t* m) { poses.push_back(m->utime); }
};

Collector collected(const std::string& config) {
  lcm::LCM lcm(kUrl);
  Collector out;
  lcm.subscribe("VO_POINTS", &Collector::on_points, &out)->setQueueCapacity(1000);
  lcm.subscribe("VO_ODOMETRY", &Collector::on_odometry, &out)->setQueueCapacity(1000);
  Subprocess daemon({binary("cliquevod"), "--config", config});
  for (int timeout_ms = 60'000; lcm.handleTimeout(timeout_ms) > 0; timeout_ms = 3000) {
  }
  const Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  out.log = end.err;
  return out;
}

TEST(PointsMessages, ComeAtTheirRateWithTheGroundBelowTheBody) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const Collector got = collected(write_config(", points_rate_hz: 5, points_step_px: 4"));
  EXPECT_EQ(got.poses.size(), static_cast<std::size_t>(kFrames));
  ASSERT_GE(got.points.size(), 5U);
  EXPECT_LE(got.points.size(), 11U) << "two seconds of frames";
  std::int64_t last_us = 0;
  for (const points_t& m : got.points) {
    EXPECT_GE(m.utime - last_us, 199'000);
    last_us = m.utime;
    EXPECT_NE(std::find(got.poses.begin(), got.poses.end(), m.utime), got.poses.end()) << "of a frame that was sent";
    EXPECT_EQ(m.step_px, 4);
    EXPECT_NEAR(m.camera_position[2], 0.85, 1e-9);
    ASSERT_EQ(m.x.size(), static_cast<std::size_t>(m.num_points));
    ASSERT_GT(m.num_points, 1000);
    EXPECT_LE(m.num_points, 64 * 48);
    int on_ground = 0;
    for (std::size_t i = 0; i < m.x.size(); ++i) {
      EXPECT_GT(m.x[i], 0.0F) << "ahead";
      const double range = std::hypot(m.x[i], m.y[i], m.z[i] - 0.85);
      EXPECT_GT(m.sigma[i], 0.0F);
      EXPECT_LT(m.sigma[i], 0.4 * range);
      on_ground += std::abs(m.z[i]) < 0.1 + 3.0 * m.sigma[i] ? 1 : 0;
    }
    EXPECT_GT(on_ground, m.num_points / 2) << "the ground is where the body stands";
  }
}

// More than it can do: frames are left out, poses are not.
TEST(PointsMessages, AsManyAsCanBeAskedForCostNoPose) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const Collector got = collected(write_config(", points_rate_hz: 1000, points_step_px: 1"));
  EXPECT_NE(got.log.find(fmt::format("{} poses sent", kFrames)), std::string::npos) << got.log;
  EXPECT_NE(got.log.find(" 0 dropped"), std::string::npos) << got.log;
  // So many bytes at once are more than a receiver's usual buffer holds: it may miss a message.
  EXPECT_GE(got.poses.size(), static_cast<std::size_t>(0.8 * kFrames));
  ASSERT_GE(got.points.size(), 1U);
  EXPECT_GT(got.points.back().num_points, 256 * 192 / 4);
}

TEST(PointsMessages, EchoPrintsThem) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  Subprocess daemon({binary("cliquevod"), "--config", write_config("", "pingpong")});
  const Finished echo = run({binary("cliquevo"), "echo", "VO_POINTS", "--json", "--count", "1", "--lcm", kUrl});
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait().exit_code, 0);
  ASSERT_EQ(echo.exit_code, 0) << echo.err;
  const auto m = nlohmann::json::parse(echo.out);
  EXPECT_GT(m["x"].size(), 1000U);
  for (const char* list : {"y", "z", "sigma", "grey"}) EXPECT_EQ(m[list].size(), m["x"].size()) << list;
  EXPECT_EQ(m["step_px"], 4);
}

}  // namespace
}  // namespace cliquevo::test
