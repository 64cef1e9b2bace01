// SPDX-License-Identifier: BSD-3-Clause
// A pair of five-megapixel cameras at 30 Hz, as grabbed, through the daemon for a minute: `rectify.scale: auto` finds
// the size at which nothing is dropped; and what that size costs in drift beside the native one.
#include <chrono>
#include <csignal>
#include <fstream>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using std::chrono::steady_clock;

constexpr double kSeconds = 60.0;
constexpr const char* kCameras = "raw=on,width=2448,height=2048,focal_px=2300,course=straight,frames=";

// The pairs as an LCM log: read from memory, the source takes no core of its own.
std::string recorded_pairs(const std::string& dir) {
  const Finished done =
      run({binary("cliquevo"), "record", fmt::format("sim:{}24", kCameras), "--out", dir + "/pairs.lcm"});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return dir + "/pairs.lcm";
}

nlohmann::json status_of(const std::string& socket) {
  const Finished asked = run({binary("cliquevo"), "ctl", "status", "--json", "--socket", socket});
  const auto parsed = nlohmann::json::parse(asked.out, nullptr, false);
  return asked.exit_code == 0 && parsed.is_object() ? parsed : nlohmann::json::object();
}

double number_after(const std::string& text, const std::string& pattern) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(pattern)) ? std::stod(found[1]) : 0.0;
}

// What the replay says of the end's error, rectified to this scale. At the native size the simulator's ground has
// corners in a strip below the horizon alone, which the bound on their spread would refuse.
std::string drift_at(const std::string& dir, double scale) {
  const std::string config = fmt::format("{}/scale.yaml", dir);
  std::ofstream(config) << fmt::format("rectify: {{scale: {}}}\nodometry: {{min_eigenvalue_ratio: 0.002}}\n", scale);
  const Finished done = run({binary("cliquevo"), "replay", fmt::format("sim:{}60", kCameras), "--config", config});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  std::smatch found;
  return std::regex_search(done.out, found, std::regex("against[^\n]*")) ? found.str() : done.out;
}

TEST(LargeSensor, AMinuteOfFiveMegapixelsAt30HzDropsNothing) {
  const std::string dir = scratch_dir();
  const std::string log = recorded_pairs(dir);
  std::ofstream(dir + "/c.yaml") << fmt::format(
      "source: {{type: recording, recording: {{path: {}}}, loop: pingpong}}\nrectify: {{scale: auto}}\n"
      "control: {{socket: {}/control}}\nlcm: {{url: \"memq://\"}}\n",
      log, dir);
  Subprocess daemon({binary("cliquevod"), "--config", dir + "/c.yaml"});
  const auto begin = steady_clock::now();
  const auto passed_s = [&] { return std::chrono::duration<double>(steady_clock::now() - begin).count(); };
  nlohmann::json first = nlohmann::json::object();
  while (first.value("poses_sent", 0) == 0 && passed_s() < 60.0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    first = status_of(dir + "/control");
  }
  ASSERT_GT(first.value("poses_sent", 0), 0) << first.dump();
  std::this_thread::sleep_for(std::chrono::duration<double>(kSeconds));
  const nlohmann::json last = status_of(dir + "/control");
  daemon.send(SIGTERM);
  const Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  const int sent = last.value("poses_sent", 0) - first.value("poses_sent", 0);
  const double dropped = number_after(end.err, "([0-9]+) dropped");
  const double scale = number_after(end.err, "auto chose ([0-9.]+)");
  EXPECT_GE(sent, static_cast<int>(29.5 * kSeconds)) << last.dump();
  EXPECT_EQ(dropped, 0.0) << end.err;
  EXPECT_GT(scale, 0.0) << end.err;
  fmt::print("{} poses in {} s, {} dropped, rectified to {} of the native size\n", sent, kSeconds, dropped, scale);
  fmt::print("at that size: {}\nnative:       {}\n", drift_at(dir, scale), drift_at(dir, 1.0));
}

}  // namespace
}  // namespace cliquevo::test
