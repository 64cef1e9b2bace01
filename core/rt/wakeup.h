// SPDX-License-Identifier: BSD-3-Clause
// Sleep and wake-up between threads on a futex: no mutex, and no system call while nobody sleeps.
#pragma once

#include <atomic>
#include <cstdint>

namespace cliquevo::rt {

// A counter that threads can sleep on. Use: read state(), look for work, and only if there is none wait(that state):
// a signal between the two is not lost.
class Wakeup {
 public:
  static constexpr std::int64_t kForever = -1;

  std::uint32_t state() const { return word_.load(std::memory_order_seq_cst); }
  // Changes the state and wakes every sleeper.
  void signal();
  // Sleeps until the state differs from `seen`, or for timeout_ns at most. true: it differs.
  bool wait(std::uint32_t seen, std::int64_t timeout_ns = kForever);

 private:
  std::atomic<std::uint32_t> word_{0};
  std::atomic<std::uint32_t> sleepers_{0};
};

}  // namespace cliquevo::rt
