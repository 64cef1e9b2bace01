// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/wakeup.h"

#include <thread>

#include <gtest/gtest.h>

#include "core/base/time.h"

namespace cliquevo::rt {
namespace {

TEST(Wakeup, ASignalBeforeTheSleepIsNotLost) {
  Wakeup wakeup;
  const std::uint32_t seen = wakeup.state();
  wakeup.signal();
  EXPECT_TRUE(wakeup.wait(seen));
}

TEST(Wakeup, WithoutASignalTheSleepEndsAtItsTimeout) {
  Wakeup wakeup;
  const std::int64_t begin = monotonic_ns();
  EXPECT_FALSE(wakeup.wait(wakeup.state(), 5'000'000));
  EXPECT_GE(monotonic_ns() - begin, 5'000'000);
  EXPECT_FALSE(wakeup.wait(wakeup.state(), 0));
}

TEST(Wakeup, TwoThreadsThatWakeEachOtherNeverMissATurn) {
  Wakeup ping;
  Wakeup pong;
  constexpr int kTurns = 20'000;
  std::thread other([&] {
    std::uint32_t seen = 0;
    for (int i = 0; i < kTurns; ++i) {
      ASSERT_TRUE(ping.wait(seen));
      seen = ping.state();
      pong.signal();
    }
  });
  std::uint32_t seen = 0;
  for (int i = 0; i < kTurns; ++i) {
    ping.signal();
    ASSERT_TRUE(pong.wait(seen, 10'000'000'000));
    seen = pong.state();
  }
  other.join();
  EXPECT_EQ(ping.state(), static_cast<std::uint32_t>(kTurns));
}

}  // namespace
}  // namespace cliquevo::rt
