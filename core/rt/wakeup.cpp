// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/wakeup.h"

#include <cerrno>
#include <ctime>
#include <limits>
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "core/base/time.h"

namespace cliquevo::rt {

namespace {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t), "the kernel looks at the word itself");

long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value, const timespec* timeout) {
  return ::syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), operation | FUTEX_PRIVATE_FLAG, value, timeout,
                   nullptr, 0);
}

}  // namespace

void Wakeup::signal() {
  word_.fetch_add(1, std::memory_order_seq_cst);
  // Either this sees the sleeper, or the sleeper, which counts itself in first, sees the new word.
  if (sleepers_.load(std::memory_order_seq_cst) != 0) {
    futex(word_, FUTEX_WAKE, static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max()), nullptr);
  }
}

bool Wakeup::wait(std::uint32_t seen, std::int64_t timeout_ns) {
  const std::int64_t end_ns = timeout_ns < 0 ? 0 : monotonic_ns() + timeout_ns;
  sleepers_.fetch_add(1, std::memory_order_seq_cst);
  bool changed = false;
  while (!(changed = word_.load(std::memory_order_seq_cst) != seen)) {
    timespec left{};
    if (timeout_ns >= 0) {
      const std::int64_t left_ns = end_ns - monotonic_ns();
      if (left_ns <= 0) break;
      left.tv_sec = left_ns / 1'000'000'000;
      left.tv_nsec = left_ns % 1'000'000'000;
    }
    // Woken, timed out, interrupted by a signal or late: the loop finds out which.
    futex(word_, FUTEX_WAIT, seen, timeout_ns < 0 ? nullptr : &left);
  }
  sleepers_.fetch_sub(1, std::memory_order_seq_cst);
  return changed;
}

}  // namespace cliquevo::rt
