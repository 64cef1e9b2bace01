// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/tcpq_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "core/base/time.h"

namespace cliquevo::daemon {
namespace {

// Accepts one client, sends `greeting`, and keeps what it gets until the client hangs up.
class Server {
 public:
  explicit Server(std::string greeting) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    ::bind(listener_, reinterpret_cast<const sockaddr*>(&at), sizeof at);
    ::listen(listener_, 1);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&at), &size);
    url = "tcpq://127.0.0.1:" + std::to_string(ntohs(at.sin_port));
    thread_ = std::thread([this, greeting = std::move(greeting)] {
      const int fd = ::accept(listener_, nullptr, nullptr);
      static_cast<void>(::send(fd, greeting.data(), greeting.size(), MSG_NOSIGNAL));
      char buffer[4096];
      for (ssize_t got = ::recv(fd, buffer, sizeof buffer, 0); got > 0; got = ::recv(fd, buffer, sizeof buffer, 0)) {
        received.append(buffer, static_cast<std::size_t>(got));
      }
      ::close(fd);
    });
  }
  ~Server() { finish(); }
  void finish() {
    if (!thread_.joinable()) return;
    thread_.join();
    ::close(listener_);
  }
  std::string url;
  std::string received;  // after finish()

 private:
  int listener_ = -1;
  std::thread thread_;
};

const std::string kGreeting("\x28\x76\x17\xfa\x00\x00\x01\x00", 8);

TEST(TcpqClient, SpeaksAsLcmsOwnClientDoes) {
  Server server(kGreeting);
  {
    auto client = TcpqClient::open(server.url);
    ASSERT_TRUE(client.ok()) << client.error().line();
    const std::uint8_t data[] = {1, 2, 3};
    EXPECT_TRUE((*client)->send("POSE", data, sizeof data));
  }
  server.finish();
  const std::string expected(
      "\x28\x76\x17\xfb\x00\x00\x01\x00"
      "\x00\x00\x00\x01\x00\x00\x00\x04POSE\x00\x00\x00\x03\x01\x02\x03",
      8 + 4 + 4 + 4 + 4 + 3);
  EXPECT_EQ(server.received, expected);
}

TEST(TcpqClient, WhatIsNoServerIsRefusedSoon) {
  for (const std::string& greeting : {std::string(), std::string("HTTP/1.1 400 Bad Request"), kGreeting.substr(0, 5)}) {
    const std::int64_t begin_ns = monotonic_ns();
    const Server server(greeting);
    const auto client = TcpqClient::open(server.url);
    ASSERT_FALSE(client.ok());
    EXPECT_NE(client.error().line().find(server.url), std::string::npos);
    EXPECT_LT(monotonic_ns() - begin_ns, 3'000'000'000);
  }
}

}  // namespace
}  // namespace cliquevo::daemon
