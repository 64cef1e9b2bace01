// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo mavlink` as an autopilot sees it: every field decoded by others' code, over UDP and a serial line.
#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <thread>
#include <unistd.h>

#include <cliquevo/odometry_t.hpp>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int kPort = 14599;
constexpr int kMessages = 20;
constexpr std::int64_t kFirstUs = 1'700'000'000'000'000;
constexpr std::int64_t kPeriodUs = 33'333;

// Numbers that a float holds, and that differ in every field and message.
odometry_t message(int n) {
  odometry_t m{};
  m.utime = kFirstUs + n * kPeriodUs;
  for (int i = 0; i < 3; ++i) {
    m.position[i] = 0.5 * n + i;
    m.velocity[i] = 0.25 * n - i;
    m.rotation_rate[i] = 0.125 * (i + 1) + n;
  }
  const double half = 0.05 * (n + 1);
  m.orientation[0] = std::cos(half);
  m.orientation[3] = std::sin(half);  // a turn to the left about Z up
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      m.pose_covariance[r][c] = 0.5 * (1 + std::min(r, c) + 6 * std::max(r, c)) + n;
      m.twist_covariance[r][c] = 0.25 * (1 + std::min(r, c) + 6 * std::max(r, c)) + n;
    }
  }
  m.quality = static_cast<std::int8_t>(4 * n);
  m.pose_is_guess = n == 7 ? 1 : 0;
  m.reset_counter = n / 8;
  return m;
}

constexpr double kSigns[6] = {1, -1, -1, 1, -1, -1};

void expect_covariance(const json& got, const double (&covariance)[6][6]) {
  ASSERT_EQ(got.size(), 21u);
  std::size_t k = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) EXPECT_EQ(got[k++].get<double>(), kSigns[r] * kSigns[c] * covariance[r][c]);
  }
}

void expect_odometry(const json& got, const odometry_t& m, int n) {
  EXPECT_EQ(got["timeUsec"], std::to_string(m.utime));
  EXPECT_EQ(got["frameId"], 20);
  EXPECT_EQ(got["childFrameId"], 12);
  EXPECT_EQ(got["estimatorType"], 2);
  const char* names[3][3] = {{"x", "y", "z"}, {"vx", "vy", "vz"}, {"rollspeed", "pitchspeed", "yawspeed"}};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(got[names[0][i]].get<double>(), kSigns[i] * m.position[i]);
    EXPECT_EQ(got[names[1][i]].get<double>(), kSigns[i] * m.velocity[i]);
    EXPECT_EQ(got[names[2][i]].get<double>(), kSigns[i] * m.rotation_rate[i]);
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(got["q"][i].get<double>(), (i >= 2 ? -1.0 : 1.0) * m.orientation[i], 1e-7);
  }
  expect_covariance(got["poseCovariance"], m.pose_covariance);
  expect_covariance(got["velocityCovariance"], m.twist_covariance);
  EXPECT_EQ(got["resetCounter"], m.reset_counter);
  EXPECT_EQ(got["quality"], n == 7 ? -1 : std::max(1, 4 * n));
}

void expect_vision(const json& got, const odometry_t& m, int n) {
  EXPECT_EQ(got["usec"], std::to_string(m.utime));
  EXPECT_EQ(got["x"].get<double>(), m.position[0]);
  EXPECT_EQ(got["y"].get<double>(), -m.position[1]);
  EXPECT_EQ(got["z"].get<double>(), -m.position[2]);
  EXPECT_NEAR(got["roll"].get<double>(), 0.0, 1e-6);
  EXPECT_NEAR(got["pitch"].get<double>(), 0.0, 1e-6);
  EXPECT_NEAR(got["yaw"].get<double>(), -0.1 * (n + 1), 1e-6);  // to the left is negative about Z down
  expect_covariance(got["covariance"], m.pose_covariance);
  EXPECT_EQ(got["resetCounter"], m.reset_counter);
}

// Waits for a line of the program's output.
void wait_for(const std::string& path, const std::string& text) {
  for (int i = 0; i < 600 && read_file(path).find(text) == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_NE(read_file(path).find(text), std::string::npos) << path;
}

// Both programs, the messages between them; what the receiver decoded, a line each.
std::vector<json> decoded(const std::string& to, const std::vector<std::string>& options, int wanted) {
  const std::string folder = scratch_dir();
  const std::string heard = folder + "/heard.txt";
  const std::string said = folder + "/said.txt";
  const auto shell = [](const std::string& command) { return std::vector<std::string>{"sh", "-c", "exec " + command}; };
  Subprocess receiver(shell("node " CLIQUEVO_PEERS_DIR "/receive_mavlink.mjs " + std::to_string(kPort) + " " +
                            std::to_string(wanted) + " > " + heard));
  wait_for(heard, "READY");
  std::string command = binary("cliquevo") + " mavlink --to " + to + " --lcm '" + kUrl + "'";
  for (const std::string& option : options) command += " " + option;
  Subprocess bridge(shell(command + " > " + said));
  wait_for(said, "VO_ODOMETRY");
  lcm::LCM lcm(kUrl);
  EXPECT_TRUE(lcm.good());
  for (int n = 0; n < kMessages; ++n) {
    const odometry_t m = message(n);
    lcm.publish("VO_ODOMETRY", &m);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  EXPECT_EQ(receiver.wait(60.0).exit_code, 0);
  bridge.send(SIGTERM);
  EXPECT_EQ(bridge.wait(10.0).exit_code, 0);
  std::vector<json> out;
  for (const std::string& line : lines_of(read_file(heard))) {
    if (line != "READY") out.push_back(json::parse(line));
  }
  return out;
}

void expect_all(const std::vector<json>& got, int system, int component) {
  int odometry = 0;
  int vision = 0;
  int heartbeats = 0;
  int answers = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const json& m = got[i];
    EXPECT_EQ(m["version"], 2);
    EXPECT_EQ(m["system"], system);
    EXPECT_EQ(m["component"], component);
    EXPECT_EQ(m["sequence"], static_cast<int>(i % 256));  // none was lost
    if (m["name"] == "ODOMETRY") expect_odometry(m, message(odometry), odometry), ++odometry;
    if (m["name"] == "VISION_POSITION_ESTIMATE") expect_vision(m, message(vision), vision), ++vision;
    if (m["name"] == "HEARTBEAT") {
      ++heartbeats;
      EXPECT_EQ(m["type"], 18);
      EXPECT_EQ(m["autopilot"], 8);
      EXPECT_EQ(m["mavlinkVersion"], 3);
    }
    if (m["name"] == "TIMESYNC") {
      ++answers;
      EXPECT_EQ(m["ts1"], "123456789");
      const auto now_ns = std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
      EXPECT_NEAR(std::stod(m["tc1"].get<std::string>()), static_cast<double>(now_ns), 120e9);
    }
  }
  EXPECT_EQ(odometry, kMessages);
  EXPECT_EQ(vision, kMessages);
  EXPECT_GE(heartbeats, 1);
  EXPECT_EQ(answers, 1);
}

TEST(Mavlink, EveryFieldArrivesOverUdp) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const auto got =
      decoded("udp:127.0.0.1:" + std::to_string(kPort),
              {"--messages", "both", "--rate", "1000", "--system", "42", "--component", "191"}, 2 * kMessages);
  expect_all(got, 42, 191);
}

// A serial line as a pseudo terminal, whose other end goes to the receiver.
class Line {
 public:
  Line() : master_(::posix_openpt(O_RDWR | O_NOCTTY)) {
    EXPECT_GE(master_, 0);
    EXPECT_EQ(::grantpt(master_) | ::unlockpt(master_), 0);
    socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(kPort);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    thread_ = std::thread([this] { relay(); });
  }
  ~Line() {
    stop_ = true;
    thread_.join();
    ::close(socket_);
    ::close(master_);
  }
  std::string device() const { return ::ptsname(master_); }

 private:
  void relay() const {
    std::uint8_t bytes[1024];
    while (!stop_) {
      pollfd ready[2] = {{master_, POLLIN, 0}, {socket_, POLLIN, 0}};
      ::poll(ready, 2, 20);
      if ((ready[0].revents & POLLIN) != 0) {
        const ssize_t got = ::read(master_, bytes, sizeof bytes);
        if (got > 0) static_cast<void>(::send(socket_, bytes, static_cast<std::size_t>(got), 0));
      }
      if ((ready[1].revents & POLLIN) != 0) {
        const ssize_t got = ::recv(socket_, bytes, sizeof bytes, 0);
        if (got > 0) static_cast<void>(!::write(master_, bytes, static_cast<std::size_t>(got)));
      }
      if ((ready[0].revents & POLLHUP) != 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  int master_;
  int socket_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST(Mavlink, EveryFieldArrivesOverASerialLine) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const Line line;
  expect_all(decoded("serial:" + line.device() + ":115200", {"--messages", "both", "--rate", "1000"}, 2 * kMessages), 1,
             197);
}

TEST(Mavlink, TheRateIsLimitedButNoDiscontinuityIsLeftOut) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const auto got = decoded("udp:127.0.0.1:" + std::to_string(kPort), {"--rate", "10"}, 7);
  std::int64_t last_us = 0;
  int last_counter = 0;
  for (const json& m : got) {
    if (m["name"] != "ODOMETRY") continue;
    const std::int64_t us = std::stoll(m["timeUsec"].get<std::string>());
    const int counter = m["resetCounter"];
    if (last_us > 0 && counter == last_counter) {
      EXPECT_GE(us - last_us, 90'000);
    }
    EXPECT_EQ((us - kFirstUs) / kPeriodUs / 8, counter);
    last_us = us;
    last_counter = counter;
  }
  EXPECT_EQ(last_counter, 2);
}

TEST(Mavlink, WrongLinksAreRefusedInALine) {
  for (const char* to :
       {"udp:nowhere", "serial:/dev/null", "serial:/dev/ttyNOPE", "serial:/dev/ttyS0:12", "tcp:1.2.3.4:5"}) {
    const Finished done = run({binary("cliquevo"), "mavlink", "--to", to, "--lcm", "memq://"});
    EXPECT_NE(done.exit_code, 0) << to;
    EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
  }
}

}  // namespace
}  // namespace cliquevo::test
