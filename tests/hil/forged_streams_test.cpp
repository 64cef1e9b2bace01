// SPDX-License-Identifier: BSD-3-Clause
// Other machines that forge the packets of cameras: the daemon goes on, and so do its poses.
#include <algorithm>
#include <arpa/inet.h>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <poll.h>
#include <random>
#include <sstream>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/hil/late_rig.h"
#include "tests/support/forged_gvsp.h"

namespace cliquevo {
namespace {

using hil::make_course;
using hil::poses;
using hil::until;
using hil::write_config;
using std::chrono::milliseconds;
using test::Bytes;
using test::GvspKind;

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
