// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/handover.h"

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/rt/slot_pool.h"

namespace cliquevo::rt {
namespace {

std::int64_t stress_items() {
  const char* set = std::getenv("CLIQUEVO_STRESS_ITEMS");
  return set != nullptr ? std::stoll(set) : 200'000;
}

struct Slot {
  std::int64_t item = -1;
  std::int64_t copy = -1;  // written last: differs from `item` when somebody else writes at the same time
};

TEST(Handover, ASlowConsumerAlwaysGetsTheNewest) {
  Handover handover;
  EXPECT_EQ(handover.put(0), Handover::kNone);
  EXPECT_EQ(handover.put(1), 0);
  EXPECT_EQ(handover.put(2), 1);
  EXPECT_TRUE(handover.has_work());
  EXPECT_EQ(handover.take(), 2);
  EXPECT_FALSE(handover.has_work());
  EXPECT_EQ(handover.take(0), Handover::kNone);
}

TEST(Handover, ClosedItGivesTheLastSlotAndThenEnds) {
  Handover handover;
  handover.put(3);
  handover.close();
  EXPECT_EQ(handover.take(), 3);
  EXPECT_EQ(handover.take(), Handover::kNone);
}

// Under a producer that never waits: what arrives rises strictly, nobody writes a slot that another reads, every item
// is either processed or dropped, the last one arrives, and the pool never runs dry.
TEST(Handover, WhatIsSentIsProcessedOrDroppedAndIndicesRiseStrictly) {
  SlotPool<Slot> pool(3, 1);
  Handover handover;
  const std::int64_t items = stress_items();
  std::int64_t dropped = 0;
  std::int64_t dry = 0;
  std::thread producer([&] {
    for (std::int64_t i = 0; i < items; ++i) {
      const int slot = pool.acquire();
      if (slot == Handover::kNone) {
        ++dry;
        continue;
      }
      pool[slot].item = i;
      pool[slot].copy = i;
      const int skipped = handover.put(slot);
      if (skipped == Handover::kNone) continue;
      pool.release(skipped);
      ++dropped;
    }
    handover.close();
  });
  std::int64_t processed = 0;
  std::int64_t last = -1;
  std::int64_t wrong = 0;
  for (int slot = handover.take(); slot != Handover::kNone; slot = handover.take()) {
    const Slot& s = pool[slot];
    if (s.item <= last || s.item != s.copy) ++wrong;
    last = s.item;
    ++processed;
    pool.give_back(0, slot);
  }
  producer.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(dry, 0);
  EXPECT_EQ(last, items - 1);
  EXPECT_EQ(processed + dropped, items);
}

TEST(Handover, AProducerThatWaitsLosesNothing) {
  SlotPool<Slot> pool(3, 1);
  Handover handover;
  constexpr std::int64_t kItems = 20'000;
  std::int64_t skipped = 0;
  std::thread producer([&] {
    for (std::int64_t i = 0; i < kItems; ++i) {
      ASSERT_TRUE(handover.wait_until_taken());
      const int slot = pool.acquire();
      ASSERT_NE(slot, Handover::kNone);
      pool[slot].item = i;
      skipped += handover.put(slot) == Handover::kNone ? 0 : 1;
    }
    handover.close();
  });
  std::int64_t expected = 0;
  for (int slot = handover.take(); slot != Handover::kNone; slot = handover.take()) {
    EXPECT_EQ(pool[slot].item, expected++);
    pool.give_back(0, slot);
  }
  producer.join();
  EXPECT_EQ(expected, kItems);
  EXPECT_EQ(skipped, 0);
}

}  // namespace
}  // namespace cliquevo::rt
