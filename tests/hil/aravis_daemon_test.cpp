// SPDX-License-Identifier: BSD-3-Clause
// The daemon and the tools on GigE Vision cameras, and what they say of cameras that cannot be opened.
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/aravis.h"
#include "tests/hil/aravis_rig.h"

namespace cliquevo {
namespace {

using hil::camera_options;
using hil::Course;
using hil::kFrames;
using hil::open;
using hil::Rig;

std::string daemon_config(const Course& course, const std::string& dir, const std::string& more = "") {
  const std::string path = dir + "/c.yaml";
  std::ofstream(path) << "source:\n  type: aravis\n  cameras: {left: HIL-LEFT, "
                         "right: HIL-RIGHT, calibration: "
                      << course.folder
                      << "/calib.txt, rate_hz: 5, exposure_us: 10000, gain: 0, "
                         "shared_clock: true"
                      << more << "}\n"
                      << "realtime: {lock_memory: false}\nlcm: {url: \"file://" << dir << "/sent.lcm?mode=w\"}\n";
  return path;
}

// Until the file has so many lines, or none has come for long.
std::size_t wait_for_poses(const std::string& path, std::size_t wanted) {
  std::size_t lines = 0;
  for (int quiet = 0; quiet < 1500; ++quiet) {
    const std::size_t now = test::lines_of(test::read_file(path)).size();
    if (now >= wanted) return now;
    if (now > lines) quiet = 0;
    lines = now;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return lines;
}

TEST(AravisHil, TheDaemonsTrajectoryIsByteForByteTheOneOfTheFiles) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  ASSERT_EQ(
      test::run({test::binary("cliquevo"), "replay", course.folder, "--trajectory", dir + "/replay.txt"}).exit_code, 0);
  bool equal = false;
  for (int attempt = 0; attempt < 4 && !equal; ++attempt) {  // where the machine is busy a frame may be dropped
    Rig rig(course, {});
    rig.wait_until_seen();
    const std::string trajectory = dir + "/daemon" + std::to_string(attempt) + ".txt";
    test::Subprocess daemon(
        {test::binary("cliquevod"), "--config", daemon_config(course, dir), "--trajectory", trajectory});
    wait_for_poses(trajectory, kFrames);
    daemon.send(SIGTERM);
    const test::Finished end = daemon.wait();
    EXPECT_EQ(end.exit_code, 0) << end.err;
    equal = test::read_file(trajectory) == test::read_file(dir + "/replay.txt");
    if (!equal) std::fprintf(stderr, "attempt %d: %s\n", attempt, end.err.c_str());
  }
  EXPECT_TRUE(equal);
}

TEST(AravisHil, ADaemonThatWasKilledGetsTheCamerasBackByItself) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  const std::string config = daemon_config(course, dir);
  for (const char* name : {"/first.txt", "/second.txt"}) {
    test::Subprocess daemon({test::binary("cliquevod"), "--config", config, "--trajectory", dir + name});
    EXPECT_GE(wait_for_poses(dir + name, 5), 5U) << name;
    daemon.send(SIGKILL);
    daemon.wait();
  }
}

TEST(AravisHil, TheRigTestSeesTheCamerasUnpluggedAndBack) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  test::Subprocess tool({"sh", "-c",
                         "exec " + test::binary("cliquevo") + " cameras test --seconds 1 --unplug --config " +
                             daemon_config(course, dir) + " >" + dir + "/out"});
  const auto reported = [&](const std::string& words) {
    for (int i = 0; i < 1500; ++i) {
      if (test::read_file(dir + "/out").find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  };
  ASSERT_TRUE(reported("unplug a camera"));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  rig.kill();
  ASSERT_TRUE(reported("lost") || reported("reconnecting")) << test::read_file(dir + "/out");
  rig.start();
  EXPECT_TRUE(reported("it came back: pairs flow")) << test::read_file(dir + "/out");
}

TEST(AravisHil, WhatCannotBeOpenedIsToldInOneLine) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  const auto held = open(camera_options(course, 10.0));
  ASSERT_NE(held, nullptr);
  const auto refusal = [&](const std::string& config) {
    const test::Finished end = test::run({test::binary("cliquevod"), "--config", config, "--check"});
    EXPECT_EQ(end.exit_code, 1);
    EXPECT_EQ(test::lines_of(end.err).size(), 1U) << end.err;
    return end.err;
  };
  EXPECT_NE(refusal(daemon_config(course, dir)).find("busy"), std::string::npos);
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.left = "NOT-THERE";
  drivers::OpenTrouble trouble = drivers::OpenTrouble::lasting;
  const auto unknown = drivers::open_aravis(options, trouble);
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(trouble, drivers::OpenTrouble::absent);
  EXPECT_NE(unknown.error().line().find("HIL-LEFT (127.0.0.1), HIL-RIGHT (127.0.0.2)"), std::string::npos)
      << unknown.error().line();
}

TEST(AravisHil, FormatsAndSizesThatDoNotFitAreToldInOneLine) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  open(camera_options(course, 10.0));
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.pixel_format = "BayerXY8";
  drivers::OpenTrouble trouble = drivers::OpenTrouble::absent;
  const auto format = drivers::open_aravis(options, trouble);
  ASSERT_FALSE(format.ok());
  EXPECT_EQ(trouble, drivers::OpenTrouble::lasting);
  EXPECT_NE(format.error().line().find(", Mono8,"), std::string::npos) << format.error().line();
  // A second rig of another size: one camera of each.
  test::Subprocess other({test::binary("cliquevo"), "hil",
                          "sim:width=160,height=120,focal_px=175,frames=2,cache_dir=none", "--pingpong",
                          "--left-address", "127.0.0.3", "--right-address", "127.0.0.4", "--left-serial", "OTHER-LEFT",
                          "--right-serial", "OTHER-RIGHT"});
  options = camera_options(course, 10.0);
  options.left = "127.0.0.1";
  options.right = "127.0.0.4";
  std::string line;
  for (int i = 0; i < 30 && line.find("unequal") == std::string::npos; ++i) {
    const auto unequal = drivers::open_aravis(options, trouble);
    ASSERT_FALSE(unequal.ok());
    line = unequal.error().line();
  }
  EXPECT_NE(line.find("320x240 and 160x120"), std::string::npos) << line;
}

TEST(AravisHil, TheListNamesWhatAnswers) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  std::vector<drivers::SeenCamera> seen;
  for (int i = 0; i < 30 && seen.size() < 2; ++i) seen = drivers::list_aravis();
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].id.substr(0, 4), "HIL-");
}

}  // namespace
}  // namespace cliquevo
