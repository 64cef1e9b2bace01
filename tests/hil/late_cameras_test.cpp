// SPDX-License-Identifier: BSD-3-Clause
// Cameras that come late: the daemon waits, says for what, and lives.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <cliquevo/health_t.hpp>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/late_rig.h"

namespace cliquevo {
namespace {

using hil::kUrl;
using hil::make_course;
using hil::occurrences;
using hil::poses;
using hil::until;
using hil::write_config;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

// What the daemon reports to a service manager.
class Manager {
 public:
  explicit Manager(const std::string& dir) : path(dir + "/notify") {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    thread_ = std::thread([this] { listen(); });
  }
  ~Manager() {
    stop_ = true;
    thread_.join();
    ::close(socket_);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  bool received(const std::string& words) const {
    const std::lock_guard guard(mutex_);
    return said_.find(words) != std::string::npos;
  }
  // The longest that the watchdog went unfed since it was ready.
  double longest_hunger_s() const { return longest_hunger_s_; }
  const std::string path;

 private:
  void listen() {
    auto fed = steady_clock::now();
    while (!stop_) {
      pollfd wait = {socket_, POLLIN, 0};
      if (::poll(&wait, 1, 20) <= 0) continue;
      char text[4096];
      const ssize_t size = ::recv(socket_, text, sizeof text, 0);
      if (size <= 0) continue;
      const std::string message(text, static_cast<std::size_t>(size));
      const auto now = steady_clock::now();
      if (message == "WATCHDOG=1") {
        if (received("READY=1")) {
          longest_hunger_s_ = std::max<double>(longest_hunger_s_, std::chrono::duration<double>(now - fed).count());
        }
        fed = now;
        continue;
      }
      const std::lock_guard guard(mutex_);
      said_ += message + "\n";
    }
  }
  int socket_ = -1;
  mutable std::mutex mutex_;
  std::string said_;
  std::atomic<double> longest_hunger_s_{0.0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The last VO_HEALTH.
class HealthReader {
 public:
  HealthReader() : lcm_(kUrl) {
    lcm_.subscribe("VO_HEALTH", &HealthReader::take, this);
    thread_ = std::thread([this] {
      while (!stop_) lcm_.handleTimeout(20);
    });
  }
  ~HealthReader() {
    stop_ = true;
    thread_.join();
  }
  HealthReader(const HealthReader&) = delete;
  HealthReader& operator=(const HealthReader&) = delete;
  int state() const { return state_; }
  std::string text() const {
    const std::lock_guard guard(mutex_);
    return text_;
  }

 private:
  void take(const lcm::ReceiveBuffer*, const std::string&, const health_t* m) {
    const std::lock_guard guard(mutex_);
    text_ = m->state_text;
    state_ = m->state;
  }
  lcm::LCM lcm_;
  mutable std::mutex mutex_;
  std::string text_;
  std::atomic<int> state_{-1};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// CLIQUEVO_ORDER_RUNS: how often; each run has another delay.
TEST(LateCameras, DaemonAndCamerasMayBeStartedInEitherOrder) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  const char* asked = std::getenv("CLIQUEVO_ORDER_RUNS");
  const int runs = asked != nullptr ? std::max(1, std::atoi(asked)) : 2;
  for (int run = 0; run < runs; ++run) {
    const bool daemon_first = run % 2 == 0;
    const std::string trajectory = dir + "/" + std::to_string(run) + ".txt";
    const std::vector<std::string> hil{test::binary("cliquevo"), "hil", course, "--pingpong"};
    const std::vector<std::string> cliquevod{test::binary("cliquevod"), "--config",
                                             write_config(dir, course + "/calib.txt"), "--trajectory", trajectory};
    test::Subprocess first(daemon_first ? cliquevod : hil);
    std::this_thread::sleep_for(milliseconds(300 + 370 * run));
    test::Subprocess second(daemon_first ? hil : cliquevod);
    EXPECT_TRUE(until([&] { return poses(trajectory) >= 5; })) << "run " << run;
    test::Subprocess& daemon = daemon_first ? first : second;
    daemon.send(SIGTERM);
    const test::Finished end = daemon.wait();
    EXPECT_EQ(end.exit_code, 0) << "run " << run << ": " << end.err;
    EXPECT_TRUE(!daemon_first || occurrences(end.err, "waiting for a camera") > 0) << end.err;
    EXPECT_LE(occurrences(end.err, "waiting for a camera: no such camera"), 2U) << end.err;  // each camera once
    test::Subprocess& cameras = daemon_first ? second : first;
    cameras.send(SIGTERM);
    cameras.wait();
  }
}

TEST(LateCameras, WhileItWaitsItSaysForWhatFeedsTheWatchdogAndEndsWhenAskedTo) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  Manager manager(dir);
  HealthReader health;
  test::Subprocess daemon({test::binary("cliquevod"), "--config", write_config(dir, course + "/calib.txt")},
                          {{"NOTIFY_SOCKET", manager.path}});
  EXPECT_TRUE(until([&] { return manager.received("STATUS=waiting for a camera: no such camera: HIL-LEFT"); }));
  EXPECT_TRUE(until([&] { return manager.received("READY=1"); }));
  EXPECT_TRUE(until([&] { return health.state() == health_t::WAITING_FOR_FRAMES; }));
  EXPECT_NE(health.text().find("no such camera: HIL-LEFT"), std::string::npos) << health.text();
  std::this_thread::sleep_for(std::chrono::seconds(4));
  daemon.send(SIGHUP);  // changes nothing here
  std::this_thread::sleep_for(milliseconds(200));
  const auto asked = steady_clock::now();
  daemon.send(SIGTERM);
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  EXPECT_LT(std::chrono::duration<double>(steady_clock::now() - asked).count(), 3.0);
  EXPECT_LT(manager.longest_hunger_s(), 1.5);
  EXPECT_EQ(occurrences(end.err, "waiting for a camera"), 1U) << end.err;
}

TEST(LateCameras, ACameraThatADeadClientStillHoldsIsWaitedFor) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  const std::string config = write_config(dir, course + "/calib.txt");
  test::Subprocess cameras({test::binary("cliquevo"), "hil", course, "--pingpong"});
  for (const char* name : {"/first.txt", "/second.txt"}) {
    test::Subprocess daemon({test::binary("cliquevod"), "--config", config, "--trajectory", dir + name});
    EXPECT_TRUE(until([&] { return poses(dir + name) >= 5; })) << name;
    daemon.send(SIGKILL);
    daemon.wait();
  }
}

TEST(LateCameras, WhatWaitingDoesNotCureEndsAtOnce) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  const auto refusal = [&](const std::string& config) {
    const test::Finished end = test::run({test::binary("cliquevod"), "--config", config});
    EXPECT_EQ(end.exit_code, 1);
    EXPECT_EQ(test::lines_of(end.err).size(), 1U) << end.err;
    return end.err;
  };
  // Known before any camera is there ...
  EXPECT_NE(refusal(write_config(dir, dir + "/none.txt")).find("none.txt"), std::string::npos);
  EXPECT_NE(refusal(write_config(dir, course + "/calib.txt", ", no_such_key: 1")).find("no_such_key"),
            std::string::npos);
  // ... and when it is.
  test::Subprocess cameras({test::binary("cliquevo"), "hil", course, "--pingpong"});
  test::Subprocess daemon(
      {test::binary("cliquevod"), "--config", write_config(dir, course + "/calib.txt", ", pixel_format: BayerXY8")});
  const test::Finished end = daemon.wait(60.0);
  EXPECT_EQ(end.exit_code, 1) << end.err;
  EXPECT_NE(end.err.find("pixel format is not offered"), std::string::npos) << end.err;
}

TEST(LateCameras, ToolsDoNotWaitUnlessAskedTo) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  const std::string config = write_config(dir, course + "/calib.txt");
  const std::vector<std::string> record{test::binary("cliquevo"), "record",    "--config", config, "--out",
                                        dir + "/a.lcm",           "--seconds", "1"};
  for (const auto& command :
       {record, std::vector<std::string>{test::binary("cliquevo"), "cameras", "test", "--config", config}}) {
    const test::Finished end = test::run(command);
    EXPECT_EQ(end.exit_code, 1);
    EXPECT_EQ(test::lines_of(end.err).size(), 1U) << end.err;
    EXPECT_NE(end.err.find("no such camera: HIL-LEFT"), std::string::npos) << end.err;
  }
  std::vector<std::string> patient = record;
  patient.insert(patient.end(), {"--wait", "60"});
  test::Subprocess recorder(patient);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  test::Subprocess cameras({test::binary("cliquevo"), "hil", course, "--pingpong"});
  const test::Finished end = recorder.wait(90.0);
  EXPECT_EQ(end.exit_code, 0) << end.err;
}

}  // namespace
}  // namespace cliquevo
