// SPDX-License-Identifier: BSD-3-Clause
// Hand-over of a slot from one stage to the next where the newest wins.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/rt/wakeup.h"

namespace cliquevo::rt {

// One place that holds the index of one slot. A ring that the consumer drains would hold back old frames while the
// consumer is busy, and once all slots were in it the newest frame would find none; here a slot that nobody has taken
// comes straight back to the producer, so the consumer finds the newest frame however late it looks, and three slots
// a hop always suffice. One producer, one consumer.
class Handover {
 public:
  static constexpr int kNone = -1;

  // Producer. Returns the slot that was skipped (the caller's again), or kNone.
  int put(int slot) {
    const int skipped = place_.exchange(slot, std::memory_order_acq_rel);
    filled_.signal();
    return skipped;
  }
  // Producer: sleeps until the place is empty, for sources that must not lose a frame. false: timed out.
  bool wait_until_taken(std::int64_t timeout_ns = Wakeup::kForever) {
    for (;;) {
      const std::uint32_t seen = emptied_.state();
      if (place_.load(std::memory_order_acquire) == kNone) return true;
      if (!emptied_.wait(seen, timeout_ns)) return false;
    }
  }
  // Producer: nothing will follow.
  void close() {
    closed_.store(true, std::memory_order_release);
    filled_.signal();
  }

  // Consumer: the newest slot; sleeps until there is one. kNone: closed and empty, or timed out.
  int take(std::int64_t timeout_ns = Wakeup::kForever) {
    for (;;) {
      const std::uint32_t seen = filled_.state();
      const bool last_look = closed_.load(std::memory_order_acquire);
      const int slot = place_.exchange(kNone, std::memory_order_acq_rel);
      if (slot != kNone) {
        emptied_.signal();
        return slot;
      }
      if (last_look || !filled_.wait(seen, timeout_ns)) return kNone;
    }
  }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  bool has_work() const { return place_.load(std::memory_order_acquire) != kNone; }

 private:
  std::atomic<int> place_{kNone};
  std::atomic<bool> closed_{false};
  Wakeup filled_;
  Wakeup emptied_;
};

}  // namespace cliquevo::rt
