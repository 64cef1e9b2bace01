// SPDX-License-Identifier: BSD-3-Clause
// Hand-over of slots from one stage to the next: after a short stall the backlog is worked off, under overload the
// newest frame wins.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/rt/wakeup.h"

namespace cliquevo::rt {

// Places for the slots that the consumer has not taken yet. A ring that the consumer drains would hold back old frames
// while the consumer is busy, and once all slots were in it the newest frame would find none; here the producer can
// take back what nobody has taken, so it always finds a place, and backlog + 3 slots a hop always suffice.
//
// A slot that finds another waiting costs patience; three in a row that find none win one back. While there is
// patience, slots wait their turn: a consumer that stood still for a moment takes them all, in order. Without it all
// that wait are skipped: a consumer that is too slow for good gets the newest, and what it is behind by never builds
// up. One producer, one consumer.
class Handover {
 public:
  static constexpr int kNone = -1;
  static constexpr int kMostBacklog = 31;

  // backlog: how many slots may wait behind another; 0: the newest always wins.
  explicit Handover(int backlog = 0)
      : backlog_(std::clamp(backlog, 0, kMostBacklog)), places_in_use_(backlog_ + 1), patience_(backlog_) {
    for (auto& place : places_) place.store(kEmpty, std::memory_order_relaxed);
  }

  // Producer. Calls skipped(slot) for each slot that is passed over (the caller's again), oldest first.
  template <typename Skipped>
  void put(int slot, Skipped&& skipped) {
    if (!has_work()) {
      if (++calm_ >= kCalm) {
        calm_ = 0;
        patience_ = std::min(patience_ + 1, backlog_);
      }
    } else {
      calm_ = 0;
      if (patience_ > 0) {
        --patience_;
      } else {
        take_back(skipped);
      }
    }
    const std::int64_t number = next_.load(std::memory_order_relaxed);
    place_of(number).store(entry(number, slot), std::memory_order_release);
    next_.store(number + 1, std::memory_order_release);
    filled_.signal();
  }
  // Producer: sleeps until nothing waits, for sources that must not lose a frame. false: timed out.
  bool wait_until_taken(std::int64_t timeout_ns = Wakeup::kForever) {
    for (;;) {
      const std::uint32_t seen = emptied_.state();
      if (!has_work()) return true;
      if (!emptied_.wait(seen, timeout_ns)) return false;
    }
  }
  // Producer: nothing will follow.
  void close() {
    closed_.store(true, std::memory_order_release);
    filled_.signal();
  }

  // Consumer: the slot whose turn it is; sleeps until there is one. kNone: closed and empty, or timed out.
  int take(std::int64_t timeout_ns = Wakeup::kForever) {
    for (;;) {
      const std::uint32_t seen = filled_.state();
      const bool last_look = closed_.load(std::memory_order_acquire);
      const int slot = take_oldest();
      if (slot != kNone) {
        emptied_.signal();
        return slot;
      }
      if (last_look || !filled_.wait(seen, timeout_ns)) return kNone;
    }
  }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  bool has_work() const {
    return std::any_of(places_.begin(), places_.begin() + places_in_use_,
                       [](const auto& place) { return place.load(std::memory_order_acquire) != kEmpty; });
  }

 private:
  static constexpr int kCalm = 3;
  // Number of the slot's turn and slot in one word, so that a place cannot change owner between check and take.
  static constexpr std::int64_t kEmpty = -1;
  static constexpr int kSlotBits = 16;
  static std::int64_t entry(std::int64_t number, int slot) { return (number << kSlotBits) | slot; }
  static int slot_of(std::int64_t entry) { return static_cast<int>(entry & ((1 << kSlotBits) - 1)); }
  std::atomic<std::int64_t>& place_of(std::int64_t number) {
    return places_[static_cast<std::size_t>(number % places_in_use_)];
  }

  template <typename Skipped>
  void take_back(Skipped& skipped) {
    const std::int64_t end = next_.load(std::memory_order_relaxed);
    for (std::int64_t number = std::max<std::int64_t>(0, end - places_in_use_); number < end; ++number) {
      const std::int64_t found = place_of(number).exchange(kEmpty, std::memory_order_acq_rel);
      if (found != kEmpty) skipped(slot_of(found));
    }
  }
  int take_oldest() {
    const std::int64_t end = next_.load(std::memory_order_acquire);
    for (turn_ = std::max(turn_, end - places_in_use_); turn_ < end; ++turn_) {
      std::int64_t found = place_of(turn_).load(std::memory_order_acquire);
      // Another number: taken back, and the place perhaps given to a later one already.
      if (found == kEmpty || found >> kSlotBits != turn_) continue;
      if (!place_of(turn_).compare_exchange_strong(found, kEmpty, std::memory_order_acq_rel)) continue;
      ++turn_;
      return slot_of(found);
    }
    return kNone;
  }

  int backlog_;
  int places_in_use_;
  std::array<std::atomic<std::int64_t>, kMostBacklog + 1> places_;
  std::atomic<std::int64_t> next_{0};  // number of the next slot that is put; the producer writes
  int patience_;                       // the producer's
  int calm_ = 0;                       // the producer's: slots in a row that found none waiting
  std::int64_t turn_ = 0;              // the consumer's: the number it looks for
  std::atomic<bool> closed_{false};
  Wakeup filled_;
  Wakeup emptied_;
};

}  // namespace cliquevo::rt
