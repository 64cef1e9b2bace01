// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/slot_pool.h"

#include <set>

#include <gtest/gtest.h>

namespace cliquevo::rt {
namespace {

TEST(SlotPool, EachSlotIsOutOnceAndAnEmptyPoolSaysSo) {
  SlotPool<int> pool(4, 2);
  std::set<int> out;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(out.insert(pool.acquire()).second);
  EXPECT_EQ(out.count(SlotPool<int>::kNone), 0u);
  EXPECT_EQ(pool.acquire(), SlotPool<int>::kNone);
}

TEST(SlotPool, SlotsComeBackFromEveryThreadsRing) {
  SlotPool<int> pool(3, 2);
  const int a = pool.acquire();
  const int b = pool.acquire();
  const int c = pool.acquire();
  pool.give_back(0, a);
  pool.give_back(1, b);
  pool.release(c);
  std::set<int> again;
  for (int i = 0; i < 3; ++i) again.insert(pool.acquire());
  EXPECT_EQ(again, (std::set<int>{a, b, c}));
  EXPECT_EQ(pool.acquire(), SlotPool<int>::kNone);
}

}  // namespace
}  // namespace cliquevo::rt
