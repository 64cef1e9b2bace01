// SPDX-License-Identifier: BSD-3-Clause
// cliquevod as a user starts it.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sched.h>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

using test::Finished;

std::string daemon_program() { return test::binary("cliquevod"); }

std::string write_file(const std::string& dir, const std::string& name, const std::string& text) {
  const std::string path = dir + "/" + name;
  std::ofstream(path) << text;
  return path;
}

// Messages go into a log: no network needed.
std::string to_log(const std::string& dir) { return "lcm: {url: \"file://" + dir + "/out.lcm?mode=w\"}\n"; }

std::string recording(const std::string& path, const std::string& more = "") {
  return "source:\n  type: recording\n  speed: 0\n  recording: {path: " + path + more + "}\n";
}

void expect_one_line(const Finished& end, const std::string& must_name) {
  EXPECT_EQ(test::lines_of(end.err).size(), 1u) << end.err;
  EXPECT_NE(end.err.find(must_name), std::string::npos) << end.err;
}

TEST(Daemon, TrajectoryIsByteForByteTheOneOfReplay) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string dir = test::scratch_dir();
  const std::string source = test::data_dir() + "/kitti_odometry_06";
  const Finished replay =
      test::run({test::binary("cliquevo"), "replay", source, "--last", "14", "--trajectory", dir + "/replay.txt"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  for (const char* workers : {"1", "2"}) {
    const std::string config = write_file(
        dir, "c.yaml", recording(source, ", last: 14") + to_log(dir) + "stereo: {workers: " + workers + "}\n");
    const Finished daemon = test::run({daemon_program(), "--config", config, "--trajectory", dir + "/daemon.txt"});
    ASSERT_EQ(daemon.exit_code, 0) << daemon.err;
    EXPECT_EQ(test::lines_of(test::read_file(dir + "/daemon.txt")).size(), 15u);
    EXPECT_EQ(test::read_file(dir + "/daemon.txt"), test::read_file(dir + "/replay.txt"));
  }
}

// Policy and cores of a thread of the program, by its name; -1: there is none.
struct Placed {
  int policy = -1;
  cpu_set_t cores{};
};
Placed placed(pid_t process, const std::string& name) {
  Placed out;
  std::error_code gone;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", gone)) {
    if (test::read_file(task.path().string() + "/comm") != name + "\n") continue;
    const pid_t thread = static_cast<pid_t>(std::stol(task.path().filename().string()));
    out.policy = ::sched_getscheduler(thread);
    ::sched_getaffinity(thread, sizeof out.cores, &out.cores);
  }
  return out;
}

TEST(Daemon, EveryStereoWorkerHasTheStageThreadsPriorityAndItsOwnCore) {
  const std::string dir = test::scratch_dir();
  const std::string config = write_file(
      dir, "c.yaml",
      "source:\n  loop: pingpong\n  simulator: {width: 160, height: 120, focal_px: 175, frames: 4, cache_dir: none}\n"
      "stereo: {workers: 2}\nrealtime: {worker_cpu: 0}\n" +
          to_log(dir));
  test::Subprocess daemon({daemon_program(), "--config", config, "--trajectory", dir + "/t.txt"});
  for (int i = 0; i < 6000 && test::read_file(dir + "/t.txt").empty(); ++i) ::usleep(10'000);
  const Placed stage = placed(daemon.pid(), "vo-stereo");
  const Placed worker = placed(daemon.pid(), "vo-stereo-2");
  daemon.send(SIGTERM);
  const Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  ASSERT_NE(stage.policy, -1);
  EXPECT_EQ(worker.policy, stage.policy);
  if (end.err.find("without real-time rights: vo-stereo") == std::string::npos) {
    EXPECT_EQ(stage.policy, SCHED_FIFO);
  }
  EXPECT_EQ(CPU_COUNT(&worker.cores), 1);
  EXPECT_TRUE(CPU_ISSET(0, &worker.cores));
}

TEST(Daemon, WrongUsageEndsWithTwoAndOneLine) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--no-such-option"}, {"stray"}, {"--config"}}) {
    std::vector<std::string> command{daemon_program()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Finished end = test::run(command);
    EXPECT_EQ(end.exit_code, 2);
    expect_one_line(end, "cliquevod --help");
  }
}

TEST(Daemon, TellsItsVersionAndHowToCallIt) {
  const Finished version = test::run({daemon_program(), "--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(test::lines_of(version.out).size(), 1u);
  const Finished help = test::run({daemon_program(), "--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* option : {"--config", "--check", "--trajectory", "--version", "Exit codes"}) {
    EXPECT_NE(help.out.find(option), std::string::npos) << option;
  }
}

TEST(Daemon, BadInputEndsWithOneAndOneLineThatNamesIt) {
  const std::string dir = test::scratch_dir();
  const auto config = [&](const std::string& text) { return write_file(dir, "c.yaml", text); };
  const auto end_of = [&](const std::string& text) { return test::run({daemon_program(), "--config", config(text)}); };
  const auto expect_refusal = [](const Finished& end, const std::string& must_name) {
    EXPECT_EQ(end.exit_code, 1) << must_name;
    expect_one_line(end, must_name);
  };
  expect_refusal(test::run({daemon_program(), "--config", dir + "/missing.yaml"}), "missing.yaml");
  expect_refusal(end_of("stereo:\n  windw: 9\n"), "c.yaml:2");
  expect_refusal(end_of("realtime:\n  stereo_priority: 100\n"), "c.yaml:2");
  expect_refusal(end_of(recording(dir + "/nothing") + to_log(dir)), "nothing");
  expect_refusal(end_of("source: {simulator: {frames: 2, cache_dir: none}}\nlcm: {url: nonsense}\n"), "nonsense");
  const Finished no_file = test::run({daemon_program(), "--config",
                                      config("source: {simulator: {frames: 2, cache_dir: none}}\n" + to_log(dir)),
                                      "--trajectory", dir + "/no/such/folder/t.txt"});
  expect_refusal(no_file, "/no/such/folder/t.txt");
}

TEST(Daemon, CheckPrintsAConfigurationThatReadsBackToItself) {
  const std::string dir = test::scratch_dir();
  const std::string config =
      write_file(dir, "c.yaml", "source: {simulator: {course: walking, cache_dir: none}}\nstereo: {window: 11}\n");
  const Finished first = test::run({daemon_program(), "--config", config, "--check"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("  window: 11\n"), std::string::npos) << first.out;
  EXPECT_NE(first.out.find("course: walking\n"), std::string::npos) << first.out;
  const Finished again =
      test::run({daemon_program(), "--config", write_file(dir, "printed.yaml", first.out), "--check"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, first.out);
}

TEST(Daemon, CheckRefusesACalibrationThatCannotBe) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string dir = test::scratch_dir();
  const std::string calibration =
      write_file(dir, "calib.txt", "P0: 0 0 601 0 0 707 183 0 0 0 1 0\nP1: 0 0 601 -379 0 707 183 0 0 0 1 0\n");
  const std::string config =
      write_file(dir, "c.yaml", recording(test::data_dir() + "/kitti_odometry_06", ", calibration: " + calibration));
  const Finished end = test::run({daemon_program(), "--config", config, "--check"});
  EXPECT_EQ(end.exit_code, 1);
  expect_one_line(end, "calib");
}

TEST(Daemon, HangupReadsTheConfigurationAgainAndSaysWhatWaitsForAStart) {
  const std::string dir = test::scratch_dir();
  const std::string base =
      "source:\n  loop: pingpong\n  simulator: {width: 160, height: 120, focal_px: 175, frames: 4, cache_dir: none}\n" +
      to_log(dir);
  const std::string config = write_file(dir, "c.yaml", base);
  test::Subprocess daemon({daemon_program(), "--config", config, "--trajectory", dir + "/t.txt"});
  const auto wait_for_pose = [&] {
    for (int i = 0; i < 6000 && test::read_file(dir + "/t.txt").empty(); ++i) ::usleep(10'000);
  };
  wait_for_pose();
  write_file(dir, "c.yaml", base + "stereo: {window: 11}\nlog: {level: debug}\n");
  daemon.send(SIGHUP);
  ::usleep(500'000);
  daemon.send(SIGTERM);
  const Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0);
  EXPECT_NE(end.err.find("stereo.window = 11 takes effect at the next start"), std::string::npos) << end.err;
  EXPECT_NE(end.err.find("log.level is now debug"), std::string::npos) << end.err;
}

}  // namespace
}  // namespace cliquevo
