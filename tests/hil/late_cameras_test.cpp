// SPDX-License-Identifier: BSD-3-Clause
// Cameras that come late, and neighbours that forge their packets: the daemon waits, says for what, and lives.
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <poll.h>
#include <random>
#include <sstream>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

#include <cliquevo/health_t.hpp>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/hil/private_network.h"
#include "tests/support/forged_gvsp.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::Bytes;
using test::GvspKind;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

bool enter_network_with_two_addresses() {
  return test::enter_private_network() && std::system("for i in 2 9; do ip address add 127.0.0.$i/8 dev lo; done") == 0;
}

#define CLIQUEVO_NEEDS_TWO_ADDRESSES() \
  if (!enter_network_with_two_addresses()) GTEST_SKIP() << "needs root and iproute2 for a network namespace"

std::string make_course() {
  const std::string folder = test::scratch_dir() + "/course";
  const test::Finished end = test::run({test::binary("cliquevo"), "simulate", "--out", folder, "--width", "320",
                                        "--height", "240", "--focal-px", "350", "--frames", "20"});
  EXPECT_EQ(end.exit_code, 0) << end.err;
  return folder;
}

std::string write_config(const std::string& dir, const std::string& calibration, const std::string& more = "") {
  const std::string path = dir + "/c.yaml";
  std::ofstream(path) << "source:\n  type: aravis\n  cameras: {left: HIL-LEFT, right: HIL-RIGHT, calibration: "
                      << calibration << ", rate_hz: 10, exposure_us: 10000, gain: 0, shared_clock: true" << more
                      << "}\nrealtime: {lock_memory: false}\nlcm: {url: \"" << kUrl << "\"}\n";
  return path;
}

bool until(const std::function<bool()>& holds, double seconds = 60.0) {
  const auto give_up = steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!holds()) {
    if (steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(milliseconds(20));
  }
  return true;
}

std::size_t poses(const std::string& path) { return test::lines_of(test::read_file(path)).size(); }

std::size_t occurrences(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

// What the daemon tells a service manager.
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

  bool heard(const std::string& words) const {
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
        if (heard("READY=1")) {
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
    EXPECT_LE(occurrences(end.err, "waiting for a camera: no such camera"), 2U) << end.err;  // each eye once
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
  EXPECT_TRUE(until([&] { return manager.heard("STATUS=waiting for a camera: no such camera: HIL-LEFT"); }));
  EXPECT_TRUE(until([&] { return manager.heard("READY=1"); }));
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

// ---- forged packets

class Forger {
 public:
  explicit Forger(const char* from) {
    socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    ::inet_pton(AF_INET, from, &address.sin_addr);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Forger() { ::close(socket_); }
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;
  void send(std::uint16_t port, const Bytes& packet) const {
    const sockaddr_in to = address_of("127.0.0.1", port);
    ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  // A register of the camera there, as anybody on the network may read it; 0 = no answer.
  std::uint32_t read_register(const char* camera, std::uint32_t at) const {
    Bytes request{0x42, 0x01};
    test::put_big_endian(request, 0x0080, 2);
    test::put_big_endian(request, 4, 2);
    test::put_big_endian(request, 77, 2);
    test::put_big_endian(request, at, 4);
    const sockaddr_in to = address_of(camera, 3956);
    ::sendto(socket_, request.data(), request.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    pollfd wait = {socket_, POLLIN, 0};
    Bytes answer(64);
    if (::poll(&wait, 1, 2000) <= 0 || ::recv(socket_, answer.data(), answer.size(), 0) < 12) return 0;
    return std::uint32_t{answer[8]} << 24U | std::uint32_t{answer[9]} << 16U | std::uint32_t{answer[10]} << 8U |
           answer[11];
  }

 private:
  static sockaddr_in address_of(const char* host, std::uint16_t port) {
    sockaddr_in out = {};
    out.sin_family = AF_INET;
    out.sin_port = htons(port);
    ::inet_pton(AF_INET, host, &out.sin_addr);
    return out;
  }
  int socket_ = -1;
};

double resident_mb(pid_t pid) {
  std::istringstream in(test::read_file("/proc/" + std::to_string(pid) + "/statm"));
  double total = 0.0;
  double resident = 0.0;
  in >> total >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) * 1e-6;
}

// Everything that makes a receiver reserve, write or read beyond a frame.
std::vector<Bytes> forgeries(std::uint64_t frame, std::mt19937& random) {
  std::vector<Bytes> out;
  for (const bool extended : {true, false}) {
    for (const std::uint32_t number : {0xfffffff0U, 0x7fffffffU, 0xffffffU, 100'000U}) {
      out.push_back(test::gvsp_packet(extended, GvspKind::trailer, frame++, number, 8));
      out.push_back(test::gvsp_packet(extended, GvspKind::payload, frame - 1, number - 2, 1400));
      out.push_back(test::gvsp_packet(extended, GvspKind::payload, frame++, number, 1400));
    }
    for (const GvspKind kind : {GvspKind::all_in, GvspKind::h264, GvspKind::multipart}) {
      out.push_back(test::gvsp_packet(extended, kind, frame++, 1, 1400));
    }
    for (const unsigned type : {2U, 4U, 5U, 6U, 10U}) {
      Bytes leader = test::gvsp_leader(extended, frame++, 0xffffffff, 0xffffffff, static_cast<std::uint16_t>(type));
      leader.resize(leader.size() + 1000, 0xff);  // parts without end
      out.push_back(leader);
    }
    for (std::size_t size = 0; size < 24; ++size) {
      Bytes torn = test::gvsp_packet(extended, GvspKind::payload, frame++, 1, 20);
      torn.resize(size);
      out.push_back(torn);
    }
  }
  for (int i = 0; i < 20; ++i) {
    Bytes noise(random() % 1400);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    out.push_back(noise);
  }
  return out;
}

TEST(ForgedStreams, NeitherGrowNorEndTheDaemonWhosePosesGoOn) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const std::string course = make_course();
  const std::string dir = test::scratch_dir();
  const std::string trajectory = dir + "/poses.txt";
  test::Subprocess cameras({test::binary("cliquevo"), "hil", course, "--pingpong"});
  test::Subprocess daemon(
      {test::binary("cliquevod"), "--config", write_config(dir, course + "/calib.txt"), "--trajectory", trajectory});
  ASSERT_TRUE(until([&] { return poses(trajectory) >= 10; }));
  const Forger stranger("127.0.0.9");
  const Forger neighbour("127.0.0.1");  // by the left camera's own address
  std::vector<std::uint16_t> ports;
  constexpr std::uint32_t kStreamPort = 0x0d00;  // of GigE Vision's bootstrap registers
  for (const char* camera : {"127.0.0.1", "127.0.0.2"}) {
    ports.push_back(static_cast<std::uint16_t>(stranger.read_register(camera, kStreamPort)));
    ASSERT_NE(ports.back(), 0) << camera;
  }
  const double before_mb = resident_mb(daemon.pid());
  double most_mb = before_mb;
  std::mt19937 random(15);
  for (int round = 0; round < 40; ++round) {
    const std::uint64_t frame = 20'000 + 200 * static_cast<std::uint64_t>(round);
    for (const std::uint16_t port : ports) {
      for (const Bytes& packet : forgeries(frame, random)) {
        stranger.send(port, packet);
        neighbour.send(port, packet);
      }
    }
    std::this_thread::sleep_for(milliseconds(25));
    most_mb = std::max(most_mb, resident_mb(daemon.pid()));
  }
  const std::size_t then = poses(trajectory);
  EXPECT_TRUE(until([&] { return poses(trajectory) >= then + 20; }, 30.0)) << "no poses any more";
  most_mb = std::max(most_mb, resident_mb(daemon.pid()));
  std::printf("%.1f MB before, at most %.1f MB\n", before_mb, most_mb);
  EXPECT_LT(most_mb, before_mb + 20.0);
  daemon.send(SIGTERM);
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
}

}  // namespace
}  // namespace cliquevo
