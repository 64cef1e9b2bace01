// SPDX-License-Identifier: BSD-3-Clause
#include "tests/hil/attacked_daemon.h"

#include <arpa/inet.h>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include <cliquevo/command_t.hpp>
#include <gtest/gtest.h>

#include "tests/support/test_data.h"

namespace cliquevo::test {

namespace {

using std::chrono::steady_clock;

constexpr double kMostGrowth = 20e6;  // bytes

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = bytes; i-- > 0;) out += static_cast<char>(value >> (8 * i));
}

}  // namespace

AttackedDaemon::AttackedDaemon(const std::string& more, const Environment& environment)
    : folder_(scratch_dir()), socket_(folder_ + "/control") {
  configure(more);
  process_ = std::make_unique<Subprocess>(
      std::vector<std::string>{binary("cliquevod"), "--config", folder_ + "/config.yaml"}, environment);
  // Its memory is all there after the first seconds.
  const auto first = status_once([](const auto& s) { return s.value("poses_sent", 0) > 30; }, 60.0);
  ok_ = first.value("poses_sent", 0) > 30;
  bytes_ = first.value("resident_bytes", 0.0);
}

void AttackedDaemon::configure(const std::string& more) const {
  std::ofstream(folder_ + "/config.yaml")
      << "source:\n  loop: pingpong\n  simulator: {width: 160, height: 120, focal_px: 175, frames: 10, cache_dir: "
         "none}\nstereo: {num_disparities: 48}\ncontrol: {socket: " +
             socket_ + "}\n" + more;
}

Finished AttackedDaemon::ctl(const std::string& request) const {
  return run({binary("cliquevo"), "ctl", request, "--socket", socket_});
}

nlohmann::json AttackedDaemon::status() const {
  const Finished asked = run({binary("cliquevo"), "ctl", "status", "--json", "--socket", socket_});
  const auto parsed = nlohmann::json::parse(asked.out, nullptr, false);
  return asked.exit_code == 0 && parsed.is_object() ? parsed : nlohmann::json::object();
}

nlohmann::json AttackedDaemon::status_once(const std::function<bool(const nlohmann::json&)>& done,
                                           double patience_s) const {
  const auto end = steady_clock::now() + std::chrono::duration<double>(patience_s);
  nlohmann::json last = status();
  while (!done(last) && steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    last = status();
  }
  return last;
}

void AttackedDaemon::expect_unharmed() {
  const auto before = status().value("poses_sent", 0);
  const auto after = status_once([&](const auto& s) { return s.value("poses_sent", 0) > before + 10; });
  EXPECT_GT(after.value("poses_sent", 0), before + 10) << after.dump();
  EXPECT_GT(before, 0);
  EXPECT_LT(after.value("resident_bytes", 1e12) - bytes_, kMostGrowth) << after.dump();
}

std::string AttackedDaemon::finish() {
  const auto begin = steady_clock::now();
  process_->send(SIGTERM);
  const Finished end = process_->wait(20.0);
  EXPECT_EQ(end.exit_code, 0) << end.err;
  EXPECT_LT(std::chrono::duration<double>(steady_clock::now() - begin).count(), 2.0);
  return end.err;
}

bool send_datagram(const std::string& address, int port, const std::string& bytes) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, address.c_str(), &to.sin_addr);
  const ssize_t sent = ::sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  ::close(fd);
  return sent == static_cast<ssize_t>(bytes.size());
}

std::string short_message(const std::string& channel, const std::string& payload) {
  std::string out = "LC02";
  put(out, 1, 4);
  return out + channel + std::string(1, '\0') + payload;
}

std::string fragment(std::uint32_t message_size, std::uint32_t offset, std::uint16_t number, std::uint16_t count,
                     const std::string& payload) {
  std::string out = "LC03";
  put(out, 7, 4);
  put(out, message_size, 4);
  put(out, offset, 4);
  put(out, number, 2);
  put(out, count, 2);
  return out + payload;
}

std::string command_payload(int command, std::int32_t length, const std::string& argument) {
  std::string out;
  put(out, static_cast<std::uint64_t>(command_t::getHash()), 8);
  put(out, 1, 8);
  put(out, static_cast<std::uint64_t>(command), 1);
  put(out, static_cast<std::uint32_t>(length), 4);
  return out + argument;
}

}  // namespace cliquevo::test
