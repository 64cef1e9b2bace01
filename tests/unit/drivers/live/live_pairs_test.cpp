// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/live_pairs.h"

#include <gtest/gtest.h>

#include "tests/unit/drivers/made_up_source.h"

namespace cliquevo::drivers {
namespace {

constexpr std::int64_t kPeriodNs = 33'333'333;
constexpr TimestampNs kUtcNs = 1'700'000'000'000'000'000;

LivePairs make(bool shared_clock) {
  PairSyncOptions options;
  options.rate_hz = 30.0;
  options.shared_clock = shared_clock;
  return LivePairs(options, 64, 48);
}

// Both cameras' frames of exposure k, the right camera's clock apart by `offset_ns`.
void push(LivePairs& pairs, std::int64_t k, std::int64_t offset_ns, bool right_too = true) {
  StereoPair pair;
  test::make_up_pair(k, test::made_up_info(), pair);
  const std::int64_t t_ns = k * kPeriodNs;
  pairs.push(CameraSide::left, {pair.left.cview(), kUtcNs + t_ns, t_ns + 5'000'000, kUtcNs + t_ns + 5'000'000});
  if (!right_too) return;
  pairs.push(CameraSide::right,
             {pair.right.cview(), kUtcNs + t_ns + offset_ns, t_ns + 6'000'000, kUtcNs + t_ns + 6'000'000});
}

TEST(LivePairs, FramesOfOneClockComeOutAsTheyAreFromTheFirstOn) {
  LivePairs pairs = make(true);
  StereoPair pair;
  for (std::int64_t k = 0; k < 20; ++k) {
    push(pairs, k, 1000);
    ASSERT_TRUE(pairs.next(pair));
    EXPECT_EQ(test::shown_pair(pair, k + 1), k);
    EXPECT_EQ(pair.index, k);
    EXPECT_EQ(pair.stamp_ns, kUtcNs + k * kPeriodNs) << "a clock on UTC is kept";
    EXPECT_EQ(pair.right_offset_ns, 1000);
    EXPECT_EQ(pair.host_ns, pair.stamp_ns + 5'000'000);
  }
}

TEST(LivePairs, WhoTakesPairsTooSlowlyGetsTheNewestAndALossThatIsCounted) {
  LivePairs pairs = make(true);
  StereoPair pair;
  push(pairs, 0, 0);
  ASSERT_TRUE(pairs.next(pair));
  for (std::int64_t k = 1; k < 51; ++k) push(pairs, k, 0);
  ASSERT_TRUE(pairs.next(pair));
  EXPECT_EQ(test::shown_pair(pair, 51), 47);
  EXPECT_EQ(pairs.overrun(), 46);
}

TEST(LivePairs, WhatComesBeforeAnybodyAsksIsNoLoss) {
  LivePairs pairs = make(true);
  for (std::int64_t k = 0; k < 50; ++k) push(pairs, k, 0);
  StereoPair pair;
  ASSERT_TRUE(pairs.next(pair));
  EXPECT_EQ(test::shown_pair(pair, 50), 46);
  EXPECT_EQ(pairs.overrun(), 0);
}

TEST(LivePairs, TellsHowDeepItsQueuesHaveBeen) {
  LivePairs pairs = make(true);
  EXPECT_EQ(pairs.queues(), "frames waiting for their partner up to 0/0, pairs ready up to 0 of 4");
  for (std::int64_t k = 0; k < 3; ++k) push(pairs, k, 0);
  EXPECT_EQ(pairs.queues(), "frames waiting for their partner up to 1/0, pairs ready up to 3 of 4");
}

TEST(LivePairs, FramesOfAnotherSizeAreIncompleteAndACameraAloneGivesNothing) {
  LivePairs pairs = make(true);
  Image<std::uint8_t> small(32, 48);
  small.fill(0);
  pairs.push(CameraSide::left, {small.cview(), kUtcNs, 0, kUtcNs});
  EXPECT_EQ(pairs.incomplete(CameraSide::left), 1);
  for (std::int64_t k = 1; k < 300; ++k) push(pairs, k, 0, false);
  pairs.set_state(CameraSide::right, "reconnecting");
  EXPECT_NE(pairs.status().find("right camera: reconnecting; right camera lost"), std::string::npos) << pairs.status();
  pairs.interrupt();
  StereoPair pair;
  EXPECT_FALSE(pairs.next(pair));
}

TEST(LivePairs, CamerasOfUnequalRatesAreToldWithWhatToDo) {
  LivePairs pairs = make(true);
  for (std::int64_t k = 0; k < 120; ++k) push(pairs, k, 0, k % 7 != 3);  // lost frames are no other rate
  EXPECT_EQ(pairs.status().find("Hz"), std::string::npos) << pairs.status();
  for (std::int64_t k = 120; k < 240; ++k) push(pairs, k, 0, k % 2 == 0);
  EXPECT_NE(pairs.status().find("the cameras send 30.0 and 15.0 Hz where rate_hz is 30.0: give both that rate"),
            std::string::npos)
      << pairs.status();
}

TEST(LivePairs, FramesWithFlawsThatCostNoPixelAreCounted) {
  LivePairs pairs = make(true);
  EXPECT_EQ(pairs.status().find("flaws"), std::string::npos);
  pairs.count_flawed(CameraSide::left);
  pairs.count_flawed(CameraSide::left);
  EXPECT_NE(pairs.status().find("taken with flaws that cost no pixel 2/0"), std::string::npos) << pairs.status();
}

TEST(HostClock, ACameraOfItsOwnTimeIsMappedByItsQuickestFrames) {
  HostClock clock;
  TimestampNs last = 0;
  for (std::int64_t k = 0; k < 1000; ++k) {
    const std::int64_t delay_ns = 4'000'000 + (k * 7919 % 100) * 100'000;  // 4 to 14 ms
    last = clock.to_utc(k * kPeriodNs, kUtcNs + k * kPeriodNs + delay_ns) - (kUtcNs + k * kPeriodNs);
  }
  EXPECT_GE(last, 3'900'000);
  EXPECT_LE(last, 5'500'000);
}

}  // namespace
}  // namespace cliquevo::drivers
