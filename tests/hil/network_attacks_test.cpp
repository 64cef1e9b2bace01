// SPDX-License-Identifier: BSD-3-Clause
// What others on the network, and other programs of the machine, can send: the daemon goes on sending poses, takes no
// memory for it, and says what happened.
#include <arpa/inet.h>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/hil/attacked_daemon.h"
#include "tests/hil/private_network.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using std::chrono::steady_clock;

constexpr const char* kGroup = "239.255.76.67";
constexpr int kPort = 7667;
constexpr const char* kCommandsOn = "lcm: {command_channel: VO_COMMAND}\n";
constexpr int kReset = 1;
constexpr int kStart = 2;

double seconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double>(steady_clock::now() - begin).count();
}

void send_torn_commands(const std::string& to) {
  for (const std::int32_t length : {0, -1, INT32_MIN, INT32_MAX, 1 << 20, 2}) {
    for (const std::string& argument : {std::string(), std::string(1, '\0'), std::string(3, 'x')}) {
      send_datagram(to, kPort, short_message("VO_COMMAND", command_payload(kReset, length, argument)));
    }
  }
  const std::string whole = short_message("VO_COMMAND", command_payload(kReset, 1));
  for (std::size_t size = 0; size < whole.size(); ++size) send_datagram(to, kPort, whole.substr(0, size));
  send_datagram(to, kPort, whole + "more");
  send_datagram(to, kPort, std::string(60'000, 'x'));
}

// Of what LCM's own receiver makes of them: a write beyond its buffer, and 256 MB of memory.
void send_fragments(const std::string& to) {
  const std::string named = std::string("VO_COMMAND") + std::string(1, '\0') + std::string(1200, 'x');
  send_datagram(to, kPort, fragment(4096, 0, 0, 3, named));
  send_datagram(to, kPort, fragment(4096, 0xffffffff, 1, 3, std::string(1200, 'x')));
  send_datagram(to, kPort, fragment(256U << 20U, 0, 0, 65535, named));
  for (std::uint32_t i = 1; i < 200; ++i) {
    send_datagram(to, kPort, fragment(256U << 20U, i * 1200, static_cast<std::uint16_t>(i), 65535, named));
  }
}

TEST(NetworkAttacks, TornCommandsAndFragmentsHarmNobody) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  for (const char* more : {"", kCommandsOn}) {
    AttackedDaemon daemon(more);
    ASSERT_TRUE(daemon.ok());
    for (const char* to : {kGroup, "127.0.0.1"}) {
      send_torn_commands(to);
      send_fragments(to);
    }
    daemon.expect_unharmed();
    const auto reported = daemon.status_once([](const auto& s) { return s.value("incident_text", "") != ""; }, 3.0);
    EXPECT_EQ(reported.value("resets", -1), 0);
    // Without the channel nobody listens, so there is nothing to report.
    EXPECT_EQ(reported.value("incident_text", "").find("damaged packets") != std::string::npos, *more != '\0')
        << reported.dump();
    daemon.finish();
  }
}

TEST(NetworkAttacks, CommandsByMulticastAreOffUnlessSwitchedOnAndNeverTakenByUnicast) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string reset = short_message("VO_COMMAND", command_payload(kReset, 1));
  {
    AttackedDaemon off;
    ASSERT_TRUE(off.ok());
    // No port is open: not even LCM's own receiver, which a publisher does not need.
    EXPECT_EQ(run({"ss", "-Hlun", "sport = :7667"}).out, "");
    for (int i = 0; i < 5; ++i) send_datagram(kGroup, kPort, reset);
    off.expect_unharmed();
    EXPECT_EQ(off.status().value("resets", -1), 0);
    off.finish();
  }
  AttackedDaemon on(kCommandsOn);
  ASSERT_TRUE(on.ok());
  for (int i = 0; i < 5; ++i) send_datagram("127.0.0.1", kPort, reset);
  on.expect_unharmed();
  EXPECT_EQ(on.status().value("resets", -1), 0);
  send_datagram(kGroup, kPort, reset);
  EXPECT_EQ(on.status_once([](const auto& s) { return s.value("resets", 0) == 1; }).value("resets", -1), 1);
  EXPECT_NE(on.finish().find("every program of this machine"), std::string::npos) << "the risk is named";
}

// A second machine: a network namespace of its own at the other end of a cable.
class OtherMachine {
 public:
  OtherMachine() : process_({"unshare", "--net", "sleep", "300"}) {
    const std::string pid = std::to_string(process_.pid());
    for (int i = 0; i < 200; ++i) {
      if (std::filesystem::read_symlink("/proc/" + pid + "/ns/net") !=
          std::filesystem::read_symlink("/proc/self/ns/net"))
        break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ok = std::system(("ip link add cable0 type veth peer name cable1 netns " + pid +
                      " && ip address add 10.77.0.1/24 dev cable0 && ip link set cable0 up && ip route del 224.0.0.0/4"
                      " && ip route add 224.0.0.0/4 dev cable0 && nsenter -t " +
                      pid +
                      " -n sh -c 'ip address add 10.77.0.2/24 dev cable1 && ip link set cable1 up && ip route add "
                      "224.0.0.0/4 dev cable1'")
                         .c_str()) == 0;
  }
  // From there, so that it gets here.
  void send(const std::string& to, const std::string& bytes) const {
    const pid_t child = ::fork();
    if (child == 0) {
      const int there = ::open(("/proc/" + std::to_string(process_.pid()) + "/ns/net").c_str(), O_RDONLY | O_CLOEXEC);
      const bool sent = ::setns(there, CLONE_NEWNET) == 0 && send_datagram(to, kPort, bytes);
      ::_exit(sent ? 0 : 1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }

  bool ok = false;

 private:
  Subprocess process_;
};

TEST(NetworkAttacks, AnotherMachinesCommandsAreNotObeyedWhileTtlIsZero) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const OtherMachine other;
  ASSERT_TRUE(other.ok);
  const std::string reset = short_message("VO_COMMAND", command_payload(kReset, 1));
  AttackedDaemon daemon(kCommandsOn);
  ASSERT_TRUE(daemon.ok());
  for (int i = 0; i < 5; ++i) {
    other.send(kGroup, reset);
    other.send("10.77.0.1", reset);
  }
  const auto reported = daemon.status_once(
      [](const auto& s) { return s.value("incident_text", "").find("another machine") != std::string::npos; }, 5.0);
  EXPECT_NE(reported.value("incident_text", "").find("another machine"), std::string::npos) << reported.dump();
  EXPECT_EQ(reported.value("resets", -1), 0);
  daemon.expect_unharmed();
  send_datagram(kGroup, kPort, reset);  // its own machine's
  EXPECT_EQ(daemon.status_once([](const auto& s) { return s.value("resets", 0) == 1; }).value("resets", -1), 1);
  daemon.finish();
}

TEST(NetworkAttacks, AFloodIsLoggedOnceASecondAtMostAndFillsNoDisk) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  AttackedDaemon daemon(std::string(kCommandsOn) + "recording: {folder: logs}\n");
  ASSERT_TRUE(daemon.ok());
  const auto begin = steady_clock::now();
  const std::string good = short_message("VO_COMMAND", command_payload(kReset, 1));
  const std::string bad = short_message("VO_COMMAND", command_payload(kReset, -1));
  const std::string start = short_message("VO_COMMAND", command_payload(kStart, 1));
  const std::string stop = short_message("VO_COMMAND", command_payload(3, 1));
  for (int i = 0; i < 5000; ++i) {
    for (const std::string& packet : {good, bad, start, stop}) send_datagram(kGroup, kPort, packet);
  }
  daemon.expect_unharmed();
  const double seconds = seconds_since(begin) + 1.0;
  EXPECT_NE(daemon.status().value("incident_text", "").find("beyond 10 a second"), std::string::npos);
  std::size_t logs = 0;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(daemon.folder() + "/logs", none)) {
    logs += entry.is_regular_file() ? 1 : 0;
  }
  EXPECT_LE(static_cast<double>(logs), 10.0 * seconds);
  std::size_t lines = 0;
  for (const std::string& line : lines_of(daemon.finish())) {
    if (line.find("damaged packets") != std::string::npos || line.find("beyond 10") != std::string::npos) ++lines;
  }
  EXPECT_GE(lines, 2U);
  EXPECT_LE(static_cast<double>(lines), 2.0 * seconds + 2.0);
}

int connect_to(const std::string& path) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? fd : -1;
}

TEST(ControlSocket, IsForOwnerAndGroupAndDoesWhatItIsTold) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  AttackedDaemon daemon("recording: {folder: logs}\n");
  ASSERT_TRUE(daemon.ok());
  struct stat status = {};
  ASSERT_EQ(::stat(daemon.socket().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0660U);
  ::chmod(daemon.folder().c_str(), 0755);
  const Finished stranger = run({"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", binary("cliquevo"),
                                 "ctl", "reset", "--socket", daemon.socket()});
  EXPECT_EQ(stranger.exit_code, 1);
  EXPECT_NE(stranger.err.find("usermod -aG cliquevo"), std::string::npos) << stranger.err;
  EXPECT_EQ(daemon.status().value("resets", -1), 0);

  EXPECT_EQ(daemon.ctl("reset").exit_code, 0);
  EXPECT_EQ(daemon.status_once([](const auto& s) { return s.value("resets", 0) == 1; }).value("resets", -1), 1);
  const Finished started = daemon.ctl("record-start");
  EXPECT_EQ(started.exit_code, 0) << started.err;
  const auto recording =
      daemon.status_once([](const auto& s) { return s.value("recording_text", "").find("recording, ") == 0; });
  EXPECT_EQ(recording.value("recording_text", "").find("recording, "), 0U) << recording.dump();
  EXPECT_NE(daemon.ctl("status").out.find("recording,"), std::string::npos);
  EXPECT_EQ(daemon.ctl("record-stop").exit_code, 0);
  daemon.finish();
  EXPECT_FALSE(std::filesystem::exists(daemon.socket()));
  const Finished nobody = daemon.ctl("status");
  EXPECT_EQ(nobody.exit_code, 1);
  EXPECT_EQ(lines_of(nobody.err).size(), 1U) << nobody.err;
}

TEST(ControlSocket, PeersThatSayNothingOrTooMuchKeepNobodyOut) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  AttackedDaemon daemon;
  ASSERT_TRUE(daemon.ok());
  std::vector<int> idle;
  for (int i = 0; i < 20; ++i) idle.push_back(connect_to(daemon.socket()));
  for (int i = 0; i < 50; ++i) {
    const int fd = connect_to(daemon.socket());
    if (fd < 0) continue;
    const std::string junk = i % 2 == 0 ? std::string(100'000, 'x') : std::string(5000, '\n');
    static_cast<void>(::send(fd, junk.data(), junk.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
    ::close(fd);
  }
  daemon.expect_unharmed();  // by the socket itself: the idle ones are hung up on
  for (const int fd : idle) ::close(fd);
  daemon.finish();
}

TEST(ControlSocket, OfADeadDaemonIsReplacedAndThatOfALiveOneIsNot) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  AttackedDaemon first;
  ASSERT_TRUE(first.ok());
  Subprocess second({binary("cliquevod"), "--config", first.folder() + "/config.yaml"});
  std::this_thread::sleep_for(std::chrono::seconds(1));
  second.send(SIGTERM);
  const Finished end = second.wait(20.0);
  EXPECT_EQ(end.exit_code, 0) << end.err;
  EXPECT_NE(end.err.find("another cliquevod listens there"), std::string::npos) << end.err;
  first.expect_unharmed();
  first.process().send(SIGKILL);
  first.process().wait();
  Subprocess third({binary("cliquevod"), "--config", first.folder() + "/config.yaml"});
  const auto status = first.status_once([](const auto& s) { return s.value("poses_sent", 0) > 5; });
  EXPECT_GT(status.value("poses_sent", 0), 5);
}

// A server of LCM's over TCP that accepts, and then sends nothing or reads nothing.
class BadServer {
 public:
  explicit BadServer(bool greets) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    ::bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at);
    ::listen(listener_, 8);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size);
    url = "tcpq://127.0.0.1:" + std::to_string(ntohs(at.sin_port));
    if (!greets) return;  // the kernel accepts all the same
    thread_ = std::thread([this] {
      for (int fd = ::accept(listener_, nullptr, nullptr); fd >= 0; fd = ::accept(listener_, nullptr, nullptr)) {
        static_cast<void>(::send(fd, "\x28\x76\x17\xfa\x00\x00\x01\x00", 8, MSG_NOSIGNAL));
        accepted_.push_back(fd);
      }
    });
  }
  ~BadServer() {
    ::shutdown(listener_, SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
    for (const int fd : accepted_) ::close(fd);
    ::close(listener_);
  }
  std::string url;

 private:
  int listener_ = -1;
  std::thread thread_;
  std::vector<int> accepted_;
};

// By hand it ends soon with a line that says this; the service waits, and ends on a signal.
void expect_bounded_start(const std::string& url, const std::string& said) {
  const std::string dir = scratch_dir();
  std::ofstream(dir + "/c.yaml") << "source: {loop: pingpong, simulator: {width: 160, height: 120, focal_px: 175, "
                                    "frames: 4, cache_dir: none}}\nstereo: {num_disparities: 48}\nlcm: {url: \"" +
                                        url + "\"}\n";
  const auto begin = steady_clock::now();
  const Finished by_hand = Subprocess({binary("cliquevod"), "--config", dir + "/c.yaml"}).wait(30.0);
  EXPECT_EQ(by_hand.exit_code, 1);
  EXPECT_NE(by_hand.err.find(said), std::string::npos) << by_hand.err;
  EXPECT_LT(seconds_since(begin), 10.0);

  Subprocess service({binary("cliquevod"), "--config", dir + "/c.yaml"}, {{"NOTIFY_SOCKET", dir + "/notify"}});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto asked = steady_clock::now();
  service.send(SIGTERM);
  EXPECT_EQ(service.wait(30.0).exit_code, 0);
  EXPECT_LT(seconds_since(asked), 2.0);
}

TEST(SilentServer, EndsAStartByHandAtOnceAndIsWaitedForByTheService) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const BadServer server(/*greets=*/false);
  expect_bounded_start(server.url, "the LCM server does not answer");
}

TEST(SilentServer, WhoseNameNoNameServerTellsHoldsUpNeitherStartNorEnd) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string settings = scratch_dir() + "/resolv.conf";
  std::ofstream(settings) << "nameserver 127.0.0.9\n";
  // Takes requests and sends nothing.
  const int name_server = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(53);
  ::inet_pton(AF_INET, "127.0.0.9", &at.sin_addr);
  ASSERT_EQ(::bind(name_server, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
  if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount(settings.c_str(), "/etc/resolv.conf", nullptr, MS_BIND, nullptr) != 0) {
    GTEST_SKIP() << "needs the right to mount";
  }
  expect_bounded_start("tcpq://lcm-server.example:7700", "the name server does not answer");
  ::umount2("/etc/resolv.conf", MNT_DETACH);
  ::close(name_server);
}

TEST(SilentServer, ThatReadsNothingHoldsUpNeitherPosesNorTheEnd) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const BadServer server(/*greets=*/true);
  AttackedDaemon daemon("lcm: {url: \"" + server.url + "\", images_channel: VO_IMAGES, images_rate_hz: 1000}\n");
  ASSERT_TRUE(daemon.ok());
  // Until neither the kernel nor the daemon takes more.
  const auto full = daemon.status_once([](const auto& s) { return s.value("send_errors", 0) > 0; }, 30.0);
  EXPECT_GT(full.value("send_errors", 0), 0) << full.dump();
  daemon.expect_unharmed();
  daemon.finish();
}

}  // namespace
}  // namespace cliquevo::test
