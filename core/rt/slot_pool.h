// SPDX-License-Identifier: BSD-3-Clause
// Frame slots: allocated once, named by index, owned by whoever holds the index.
#pragma once

#include <memory>
#include <vector>

#include "core/rt/handover.h"
#include "core/rt/ring.h"

namespace cliquevo::rt {

// One thread acquires. Every thread that gives slots back does so over a return ring of its own; a ring holds every
// slot and so never fills.
template <typename Slot>
class SlotPool {
 public:
  static constexpr int kNone = Handover::kNone;

  SlotPool(int slots, int returning_threads) : slots_(static_cast<std::size_t>(slots)) {
    free_.reserve(slots_.size());
    for (int i = slots - 1; i >= 0; --i) free_.push_back(i);
    for (int i = 0; i < returning_threads; ++i) returns_.push_back(std::make_unique<Ring<int>>(slots_.size()));
  }

  Slot& operator[](int index) { return slots_[static_cast<std::size_t>(index)]; }
  int size() const { return static_cast<int>(slots_.size()); }

  // The acquiring thread only. kNone: all are out.
  int acquire() {
    if (free_.empty()) collect();
    if (free_.empty()) return kNone;
    const int index = free_.back();
    free_.pop_back();
    return index;
  }
  // The acquiring thread only: a slot that never left it, or came straight back.
  void release(int index) { free_.push_back(index); }
  // Any other thread, each with a number of its own below `returning_threads`.
  void give_back(int thread, int index) { returns_[static_cast<std::size_t>(thread)]->push(index); }

 private:
  void collect() {
    int index = kNone;
    for (const auto& ring : returns_) {
      while (ring->pop(index)) free_.push_back(index);
    }
  }

  std::vector<Slot> slots_;
  std::vector<int> free_;
  std::vector<std::unique_ptr<Ring<int>>> returns_;
};

}  // namespace cliquevo::rt
