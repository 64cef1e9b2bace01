// SPDX-License-Identifier: BSD-3-Clause
// What reaches a GigE Vision stream's socket through its filter.
#include "drivers/aravis/stream_guard.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/forged_gvsp.h"

namespace cliquevo::drivers {
namespace {

using test::Bytes;
using test::GvspKind;

constexpr std::uint32_t kLoopback = 0x7f000001;
constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr std::size_t kPayload = kWidth * kHeight;
constexpr std::size_t kPacket = 1500;
// What a frame of such a camera has: 1500 bytes less 28 of IP and UDP and 8 or 20 of its own.
constexpr std::uint32_t kBlocks = (kPayload + 1463) / 1464;
constexpr std::uint32_t kExtendedBlocks = (kPayload + 1451) / 1452;

StreamShape shape(std::uint32_t camera_address) { return {camera_address, kPayload, kPacket, kWidth, kHeight}; }

// A guarded socket, and another one that sends to it.
class Guarded {
 public:
  explicit Guarded(const StreamShape& shape) {
    receiver_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    sender_ = ::socket(AF_INET, SOCK_DGRAM, 0);
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(kLoopback);
    EXPECT_EQ(::bind(receiver_, reinterpret_cast<sockaddr*>(&address_), sizeof address_), 0);
    socklen_t size = sizeof address_;
    ::getsockname(receiver_, reinterpret_cast<sockaddr*>(&address_), &size);
    const auto ok = guard_stream(ntohs(address_.sin_port), stream_filter(shape));
    EXPECT_TRUE(ok.ok()) << (ok.ok() ? "" : ok.error().line());
  }
  ~Guarded() {
    ::close(receiver_);
    ::close(sender_);
  }
  Guarded(const Guarded&) = delete;
  Guarded& operator=(const Guarded&) = delete;

  // On loopback a datagram is there, or dropped, when it has been sent.
  bool lets_through(const Bytes& packet) {
    ::sendto(sender_, packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&address_), sizeof address_);
    Bytes got(65536);
    const ssize_t size = ::recv(receiver_, got.data(), got.size(), MSG_DONTWAIT);
    return size >= 0 && static_cast<std::size_t>(size) == packet.size();
  }

 private:
  int receiver_ = -1;
  int sender_ = -1;
  sockaddr_in address_ = {};
};

TEST(StreamGuard, AWholeFrameComesThroughWithEitherHeader) {
  Guarded stream(shape(kLoopback));
  for (const bool extended : {false, true}) {
    const std::uint32_t blocks = extended ? kExtendedBlocks : kBlocks;
    EXPECT_TRUE(stream.lets_through(test::gvsp_leader(extended, 7, kWidth, kHeight)));
    for (std::uint32_t i = 1; i <= blocks; ++i) {
      EXPECT_TRUE(stream.lets_through(test::gvsp_packet(extended, GvspKind::payload, 7, i, 100))) << i;
    }
    EXPECT_TRUE(stream.lets_through(test::gvsp_packet(extended, GvspKind::trailer, 7, blocks + 1, 8)));
  }
}

TEST(StreamGuard, PacketNumbersThatNoFrameOfTheCameraHasAreDropped) {
  Guarded stream(shape(kLoopback));
  for (const bool extended : {false, true}) {
    const std::uint32_t blocks = extended ? kExtendedBlocks : kBlocks;
    for (const std::uint32_t number : {std::uint32_t{0}, blocks + 1, blocks + 2, 0xffffffU}) {
      EXPECT_FALSE(stream.lets_through(test::gvsp_packet(extended, GvspKind::payload, 8, number, 100))) << number;
    }
    for (const std::uint32_t number : {std::uint32_t{0}, blocks + 2, 0xffffffU}) {
      EXPECT_FALSE(stream.lets_through(test::gvsp_packet(extended, GvspKind::trailer, 8, number, 8))) << number;
    }
  }
  EXPECT_FALSE(stream.lets_through(test::gvsp_packet(true, GvspKind::trailer, 8, 0xfffffff0U, 8)));
}

TEST(StreamGuard, LeadersOfOtherImagesAndKindsThatAreNoneOfOursAreDropped) {
  Guarded stream(shape(kLoopback));
  for (const bool extended : {false, true}) {
    EXPECT_FALSE(stream.lets_through(test::gvsp_leader(extended, 9, kWidth + 1, kHeight)));
    EXPECT_FALSE(stream.lets_through(test::gvsp_leader(extended, 9, kWidth, 1U << 31U)));
    for (const unsigned payload_type : {0U, 2U, 4U, 5U, 10U, 0x3fffU}) {
      EXPECT_FALSE(stream.lets_through(
          test::gvsp_leader(extended, 9, kWidth, kHeight, static_cast<std::uint16_t>(payload_type))));
    }
    EXPECT_TRUE(stream.lets_through(test::gvsp_leader(extended, 9, kWidth, kHeight, 0x4001)));  // with chunks
    for (const int kind : {0, 4, 5, 6, 7, 8, 127}) {
      EXPECT_FALSE(stream.lets_through(test::gvsp_packet(extended, static_cast<GvspKind>(kind), 9, 1, 100))) << kind;
    }
  }
}

TEST(StreamGuard, TornPacketsAreDropped) {
  Guarded stream(shape(kLoopback));
  for (const bool extended : {false, true}) {
    const std::size_t header = extended ? 20 : 8;
    Bytes leader = test::gvsp_leader(extended, 10, kWidth, kHeight);
    for (leader.pop_back(); !leader.empty(); leader.pop_back()) EXPECT_FALSE(stream.lets_through(leader));
    for (const GvspKind kind : {GvspKind::payload, GvspKind::trailer}) {
      Bytes packet = test::gvsp_packet(extended, kind, 10, 1, 0);
      EXPECT_EQ(packet.size(), header);
      for (; !packet.empty(); packet.pop_back()) EXPECT_FALSE(stream.lets_through(packet)) << packet.size();
    }
  }
  EXPECT_FALSE(stream.lets_through({}));
}

TEST(StreamGuard, WhatComesFromAnotherAddressIsDropped) {
  Guarded stream(shape(kLoopback + 8));
  EXPECT_FALSE(stream.lets_through(test::gvsp_leader(false, 11, kWidth, kHeight)));
  EXPECT_FALSE(stream.lets_through(test::gvsp_packet(true, GvspKind::payload, 11, 1, 100)));
}

TEST(StreamGuard, AStreamThatCannotBeGuardedIsAnError) {
  EXPECT_FALSE(guard_stream(1, stream_filter(shape(kLoopback))).ok());
  EXPECT_FALSE(
      Guarded({kLoopback, kPayload, 48, kWidth, kHeight}).lets_through(test::gvsp_leader(false, 12, kWidth, kHeight)));
}

}  // namespace
}  // namespace cliquevo::drivers
