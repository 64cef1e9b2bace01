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

using Slots = std::vector<int>;

// The slots that were passed over.
Slots put(Handover& handover, int slot) {
  Slots skipped;
  handover.put(slot, [&](int each) { skipped.push_back(each); });
  return skipped;
}

TEST(Handover, ASlowConsumerAlwaysGetsTheNewest) {
  Handover handover;
  EXPECT_EQ(put(handover, 0), Slots{});
  EXPECT_EQ(put(handover, 1), Slots{0});
  EXPECT_EQ(put(handover, 2), Slots{1});
  EXPECT_TRUE(handover.has_work());
  EXPECT_EQ(handover.take(), 2);
  EXPECT_FALSE(handover.has_work());
  EXPECT_EQ(handover.take(0), Handover::kNone);
}

TEST(Handover, AHiccupIsCaughtUpWithInOrder) {
  Handover handover(3);
  for (const int slot : {0, 1, 2, 3}) EXPECT_EQ(put(handover, slot), Slots{});
  for (const int slot : {0, 1, 2, 3}) EXPECT_EQ(handover.take(0), slot);
  EXPECT_EQ(handover.take(0), Handover::kNone);
}

TEST(Handover, BeyondTheBacklogAllThatWaitAreSkippedAndTheNewestIsThere) {
  Handover handover(3);
  for (const int slot : {0, 1, 2, 3}) put(handover, slot);
  EXPECT_EQ(handover.take(0), 0);
  EXPECT_EQ(put(handover, 4), (Slots{1, 2, 3}));
  EXPECT_EQ(handover.take(0), 4);
  EXPECT_FALSE(handover.has_work());
}

// A consumer that is too slow for good: after the patience, it gets the newest each time.
TEST(Handover, UnderOverloadNothingBuildsUp) {
  Handover handover(3);
  int newest = 0;
  for (int i = 0; i < 3; ++i) put(handover, newest++);
  EXPECT_EQ(handover.take(0), 0);
  for (int turn = 0; turn < 100; ++turn) {
    put(handover, newest++);
    put(handover, newest++);
    const int taken = handover.take(0);
    if (turn > 0) {
      EXPECT_EQ(taken, newest - 1);
    }
  }
}

TEST(Handover, PatienceComesBackWithSlotsThatNeedNotWait) {
  Handover handover(2);
  const auto hiccup_skips = [&] {
    std::size_t skipped = 0;
    for (int i = 0; i < 3; ++i) skipped += put(handover, i).size();
    while (handover.take(0) != Handover::kNone) {
    }
    return skipped;
  };
  const auto calm = [&](int slots) {
    for (int i = 0; i < slots; ++i) {
      put(handover, 0);
      handover.take(0);
    }
  };
  EXPECT_EQ(hiccup_skips(), 0u);
  EXPECT_EQ(hiccup_skips(), 2u);  // one after the other is no hiccup
  calm(3);
  EXPECT_EQ(hiccup_skips(), 2u);  // one waited, then both were skipped
  calm(6);
  EXPECT_EQ(hiccup_skips(), 0u);
}

TEST(Handover, ClosedItGivesTheLastSlotAndThenEnds) {
  Handover handover;
  put(handover, 3);
  handover.close();
  EXPECT_EQ(handover.take(), 3);
  EXPECT_EQ(handover.take(), Handover::kNone);
}

// Under a producer that never waits: what arrives rises strictly, nobody writes a slot that another reads, every item
// is either processed or dropped, the last one arrives, and the pool never runs dry.
class HandoverUnderLoad : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Backlogs, HandoverUnderLoad, testing::Values(0, 1, 5, Handover::kMostBacklog));

TEST_P(HandoverUnderLoad, WhatIsSentIsProcessedOrDroppedAndIndicesRiseStrictly) {
  SlotPool<Slot> pool(GetParam() + 3, 1);
  Handover handover(GetParam());
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
      handover.put(slot, [&](int skipped) {
        pool.release(skipped);
        ++dropped;
      });
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
      handover.put(slot, [&](int) { ++skipped; });
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
