// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/ring.h"

#include <cstdlib>
#include <string>
#include <thread>

#include <gtest/gtest.h>

namespace cliquevo::rt {
namespace {

// The stress runs of the label `bench` raise it to 10^8.
std::int64_t stress_items() {
  const char* set = std::getenv("CLIQUEVO_STRESS_ITEMS");
  return set != nullptr ? std::stoll(set) : 200'000;
}

TEST(Ring, EveryItemArrivesOnceAndInOrder) {
  Ring<std::int64_t> ring(64);
  const std::int64_t items = stress_items();
  std::thread producer([&] {
    for (std::int64_t i = 0; i < items; ++i) {
      while (!ring.push(i)) std::this_thread::yield();
    }
    ring.close();
  });
  std::int64_t expected = 0;
  std::int64_t wrong = 0;
  std::int64_t item = -1;
  while (ring.wait_pop(item)) wrong += item == expected++ ? 0 : 1;
  producer.join();
  EXPECT_EQ(expected, items);
  EXPECT_EQ(wrong, 0);
}

TEST(Ring, AFullRingRefusesAndKeepsWhatItHas) {
  Ring<int> ring(2);
  EXPECT_TRUE(ring.push(1));
  EXPECT_TRUE(ring.push(2));
  EXPECT_FALSE(ring.push(3));
  int item = 0;
  EXPECT_TRUE(ring.pop(item));
  EXPECT_EQ(item, 1);
  EXPECT_TRUE(ring.push(3));
  EXPECT_EQ(ring.size(), 2u);
}

TEST(Ring, AClosedRingGivesWhatIsLeftAndThenEnds) {
  Ring<int> ring(4);
  ring.push(1);
  ring.close();
  int item = 0;
  EXPECT_TRUE(ring.wait_pop(item));
  EXPECT_FALSE(ring.wait_pop(item));
}

TEST(Ring, WaitingEndsAtItsTimeout) {
  Ring<int> ring(4);
  int item = 0;
  EXPECT_FALSE(ring.wait_pop(item, 1'000'000));
}

}  // namespace
}  // namespace cliquevo::rt
