// SPDX-License-Identifier: BSD-3-Clause
// The package, installed by apt on a bare Debian, and its service under a systemd that has booted.
#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>

#include <cliquevo/pose_t.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/support/test_data.h"
#include "tests/system/booted_root.h"

namespace cliquevo::test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

class ServiceTest : public testing::Test {
 protected:
  void SetUp() override {
    static const std::string why_not = install_package();
    if (why_not.rfind("needs ", 0) == 0) GTEST_SKIP() << why_not;
    ASSERT_EQ(why_not, "");
  }

  // The pose messages that an independent program records within the time.
  static std::vector<pose_t> poses_within(const BootedRoot& root, double time_s) {
    const std::string path = scratch_dir() + "/poses.lcm";
    Subprocess logger(root.in_its_network({"lcm-logger", "--quiet", "--force", "--channel=POSE_BODY",
                                           "--lcm-url=udpm://239.255.76.67:7667?ttl=0", path}));
    std::this_thread::sleep_for(std::chrono::duration<double>(time_s));
    logger.send(SIGINT);
    logger.wait(10.0);
    lcm::LogFile log(path, "r");
    std::vector<pose_t> poses;
    while (const lcm::LogEvent* event = log.good() ? log.readNextEvent() : nullptr) {
      pose_t pose;
      if (pose.decode(event->data, 0, event->datalen) > 0) poses.push_back(pose);
    }
    return poses;
  }
};

// Rights come from the unit's limits; a machine that may not raise limits gives them as capabilities instead.
void grant_rights(const BootedRoot& root) {
  rlimit memory{};
  ::getrlimit(RLIMIT_MEMLOCK, &memory);
  const rlimit wanted{RLIM_INFINITY, RLIM_INFINITY};
  if (::setrlimit(RLIMIT_MEMLOCK, &wanted) == 0) {
    ::setrlimit(RLIMIT_MEMLOCK, &memory);
    return;
  }
  root.write("/run/systemd/system/cliquevod.service.d/rights.conf",
             "[Service]\nCapabilityBoundingSet=CAP_IPC_LOCK CAP_SYS_NICE\n"
             "AmbientCapabilities=CAP_IPC_LOCK CAP_SYS_NICE\n");
  root.run({"systemctl", "daemon-reload"});
}

TEST_F(ServiceTest, TheUnitIsSoundAndSandboxed) {
  const auto root = BootedRoot::boot();
  ASSERT_TRUE(root);
  const Finished verify = root->run({"systemd-analyze", "verify", "--man=no", "/lib/systemd/system/cliquevod.service"});
  EXPECT_EQ(verify.exit_code, 0);
  EXPECT_EQ(verify.out + verify.err, "");
  const Finished security = root->run({"systemd-analyze", "security", "--no-pager", "--threshold=20", "cliquevod"});
  const auto lines = lines_of(security.out);
  EXPECT_EQ(security.exit_code, 0) << (lines.empty() ? security.err : lines.back());
}

TEST_F(ServiceTest, StartsReloadsAndEndsAsSystemdExpects) {
  const auto root = BootedRoot::boot();
  ASSERT_TRUE(root);
  grant_rights(*root);
  root->write("/etc/cliquevo/cliquevo.yaml", "source: {loop: pingpong, simulator: {frames: 30}}\n");
  const Finished started = root->run({"systemctl", "start", "cliquevod"});
  ASSERT_EQ(started.exit_code, 0) << started.err << root->run({"journalctl", "-u", "cliquevod", "--no-pager"}).out;
  EXPECT_EQ(root->property("ActiveState"), "active");

  const auto poses = poses_within(*root, 3.0);
  EXPECT_GT(poses.size(), 10U);
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_GT(poses[i].utime, poses[i - 1].utime);
  EXPECT_NE(root->property("StatusText").find("running"), std::string::npos) << root->property("StatusText");

  // Commands come through a socket that is the daemon's user's and group's.
  const Finished asked = root->run({"cliquevo", "ctl", "status"});
  EXPECT_EQ(asked.exit_code, 0) << asked.err;
  EXPECT_NE(asked.out.find("running"), std::string::npos) << asked.out;
  EXPECT_EQ(root->run({"stat", "-c", "%a %U %G", "/run/cliquevo", "/run/cliquevo/control"}).out,
            "750 cliquevo cliquevo\n660 cliquevo cliquevo\n");
  EXPECT_EQ(root->run({"setpriv", "--reuid=65534", "--clear-groups", "cliquevo", "ctl", "reset"}).exit_code, 1);

  for (const char* name : {"vo-stereo", "vo-odometry"}) {
    const auto thread = root->thread_of_daemon(name);
    ASSERT_TRUE(thread) << name;
    EXPECT_EQ(::sched_getscheduler(*thread) & ~SCHED_RESET_ON_FORK, SCHED_FIFO) << name;
  }
  const std::string status = read_file(fmt::format("/proc/{}/status", *root->daemon()));
  EXPECT_EQ(status.find("VmLck:\t       0 kB"), std::string::npos) << status;

  root->write("/etc/cliquevo/cliquevo.yaml",
              "source: {loop: pingpong, simulator: {frames: 30}}\nlog: {level: debug}\n");
  EXPECT_EQ(root->run({"systemctl", "reload", "cliquevod"}).exit_code, 0);
  EXPECT_NE(root->run({"journalctl", "-u", "cliquevod", "--no-pager"}).out.find("log.level is now debug"),
            std::string::npos);
  EXPECT_EQ(root->property("ActiveState"), "active");
  // A change of state can be searched for.
  const Finished running = root->run({"journalctl", "--no-pager", "-o", "json", "CLIQUEVO_STATE=running"});
  EXPECT_NE(running.out.find("\"CLIQUEVO_FRAMES_DROPPED\""), std::string::npos) << running.out << running.err;

  const auto begin = Clock::now();
  EXPECT_EQ(root->run({"systemctl", "stop", "cliquevod"}).exit_code, 0);
  RecordProperty("stop_s", fmt::format("{:.2f}", seconds_since(begin)));
  fmt::print("stopped within {:.2f} s\n", seconds_since(begin));
  EXPECT_EQ(root->property("Result"), "success");  // not killed at the end of its patience
  EXPECT_EQ(root->property("NRestarts"), "0");
}

// One thread stands still as a hung driver or a dead lock would make it, by a debugger's means.
TEST_F(ServiceTest, AHungStageIsRestartedWithPoses) {
  const auto root = BootedRoot::boot();
  ASSERT_TRUE(root);
  root->write("/etc/cliquevo/cliquevo.yaml", "source: {loop: pingpong, simulator: {frames: 30}}\n");
  ASSERT_EQ(root->run({"systemctl", "start", "cliquevod"}).exit_code, 0);
  const auto thread = root->thread_of_daemon("vo-stereo");
  ASSERT_TRUE(thread);
  ASSERT_EQ(::ptrace(PTRACE_SEIZE, *thread, nullptr, nullptr), 0);
  ASSERT_EQ(::ptrace(PTRACE_INTERRUPT, *thread, nullptr, nullptr), 0);
  const auto begin = Clock::now();
  bool back = false;
  bool gone = false;
  while (!back && seconds_since(begin) < 30.0) {
    int status = 0;
    if (!gone && ::waitpid(*thread, &status, __WALL | WNOHANG) == *thread)
      gone = WIFSIGNALED(status) || WIFEXITED(status);
    back = gone && root->property("NRestarts") == "1" && root->property("ActiveState") == "active";
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(back) << root->run({"journalctl", "-u", "cliquevod", "--no-pager"}).out;
  RecordProperty("back_s", fmt::format("{:.2f}", seconds_since(begin)));
  fmt::print("back within {:.2f} s\n", seconds_since(begin));
  EXPECT_GT(poses_within(*root, 2.0).size(), 5U);
}

TEST_F(ServiceTest, ABadConfigurationEndsItOnceWithItsOwnCode) {
  const auto root = BootedRoot::boot();
  ASSERT_TRUE(root);
  root->write("/etc/cliquevo/cliquevo.yaml", "sauce: {}\n");
  EXPECT_NE(root->run({"systemctl", "start", "cliquevod"}).exit_code, 0);
  EXPECT_TRUE(root->wait_for("ActiveState", "failed", 10.0));
  std::this_thread::sleep_for(std::chrono::seconds(1));  // longer than the pause before a restart
  EXPECT_EQ(root->property("ActiveState"), "failed");
  EXPECT_EQ(root->property("ExecMainStatus"), "1");
  EXPECT_EQ(root->property("NRestarts"), "0");
  const std::string log = root->run({"journalctl", "-u", "cliquevod", "--no-pager"}).out;
  EXPECT_NE(log.find("unknown key 'sauce': /etc/cliquevo/cliquevo.yaml:1"), std::string::npos) << log;
}

// A vehicle's network may come up late or when somebody plugs it in.
TEST_F(ServiceTest, WaitsForARouteAndThenPublishes) {
  const auto root = BootedRoot::boot(/*without_route=*/true);
  ASSERT_TRUE(root);
  root->write("/etc/cliquevo/cliquevo.yaml", "source: {loop: pingpong, simulator: {frames: 30}}\n");
  ASSERT_EQ(root->run({"systemctl", "start", "cliquevod"}).exit_code, 0);
  EXPECT_EQ(root->property("StatusText"), "waiting for a route for LCM messages");
  EXPECT_EQ(root->property("ActiveState"), "active");
  ASSERT_EQ(run(root->in_its_network({"ip", "link", "set", "lo", "multicast", "on"})).exit_code, 0);
  ASSERT_EQ(run(root->in_its_network({"ip", "route", "add", "224.0.0.0/4", "dev", "lo"})).exit_code, 0);
  std::size_t poses = 0;
  for (int i = 0; i < 10 && poses == 0; ++i) poses = poses_within(*root, 1.0).size();
  EXPECT_GT(poses, 0U);
}

}  // namespace
}  // namespace cliquevo::test
