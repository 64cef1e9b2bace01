// SPDX-License-Identifier: BSD-3-Clause
// A single-producer single-consumer ring that the consumer can sleep on.
#pragma once

#include <atomic>
#include <cstddef>

#include <boost/lockfree/spsc_queue.hpp>

#include "core/rt/wakeup.h"

namespace cliquevo::rt {

// One thread pushes, one pops. All memory is taken at construction.
template <typename T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : queue_(capacity) {}

  // Producer. false: full, `value` was not taken.
  bool push(const T& value) {
    if (!queue_.push(value)) return false;
    wakeup_.signal();
    return true;
  }
  // Producer: nothing will follow.
  void close() {
    closed_.store(true, std::memory_order_release);
    wakeup_.signal();
  }

  // Consumer. false: empty.
  bool pop(T& value) { return queue_.pop(value); }
  // Consumer: sleeps until there is something. false: closed and empty, or timed out.
  bool wait_pop(T& value, std::int64_t timeout_ns = Wakeup::kForever) {
    for (;;) {
      const std::uint32_t seen = wakeup_.state();
      const bool last_look = closed_.load(std::memory_order_acquire);  // before the pop: what was pushed before is seen
      if (queue_.pop(value)) return true;
      if (last_look || !wakeup_.wait(seen, timeout_ns)) return false;
    }
  }
  bool closed() const { return closed_.load(std::memory_order_acquire); }
  std::size_t size() const { return queue_.read_available(); }  // exact only for the consumer

 private:
  boost::lockfree::spsc_queue<T> queue_;
  Wakeup wakeup_;
  std::atomic<bool> closed_{false};
};

}  // namespace cliquevo::rt
