// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/time.h"

namespace cliquevo::daemon {

// Progress of a stage, seen from outside. The producer counts work in; the consumer counts it out, or the producer when
// it is skipped.
class Progress {
 public:
  void entered() {
    if (entered_.load(std::memory_order_relaxed) == left_.load(std::memory_order_relaxed)) touch();
    entered_.fetch_add(1, std::memory_order_relaxed);
  }
  void skipped() { left_.fetch_add(1, std::memory_order_relaxed); }
  void done() {
    touch();
    left_.fetch_add(1, std::memory_order_relaxed);
  }
  // How long there has been work without any being finished; 0 when there is none.
  std::int64_t standing_still_ns() const {
    const std::int64_t left = left_.load(std::memory_order_relaxed);
    if (entered_.load(std::memory_order_relaxed) <= left) return 0;
    const std::int64_t still = monotonic_ns() - last_activity_ns_.load(std::memory_order_relaxed);
    return still > 0 ? still : 0;
  }

 private:
  void touch() { last_activity_ns_.store(monotonic_ns(), std::memory_order_relaxed); }
  std::atomic<std::int64_t> entered_{0};
  std::atomic<std::int64_t> left_{0};
  std::atomic<std::int64_t> last_activity_ns_{0};
};

}  // namespace cliquevo::daemon
