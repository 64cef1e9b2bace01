// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/worker_pool.h"

#include <chrono>
#include <utility>

namespace cliquevo::stereo {

namespace {

// Waking a sleeper takes some 50 us: what comes sooner is waited for awake.
constexpr std::chrono::microseconds kAwake{40};

void breathe() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

template <typename Value>
void wait_for_change(const std::atomic<Value>& value, Value old, bool awake) {
  if (awake) {
    const auto end = std::chrono::steady_clock::now() + kAwake;
    do {
      for (int i = 0; i < 20; ++i) {
        if (value.load() != old) return;
        breathe();
      }
    } while (std::chrono::steady_clock::now() < end);
  }
  value.wait(old);
}

}  // namespace

WorkerPool::WorkerPool(int workers) : awake_(workers <= static_cast<int>(std::thread::hardware_concurrency())) {
  for (int i = 1; i < workers; ++i) threads_.emplace_back([this, i] { work(i); });
}

WorkerPool::~WorkerPool() {
  stop_.store(true);
  round_.fetch_add(1);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::vector<std::thread::native_handle_type> WorkerPool::handles() {
  std::vector<std::thread::native_handle_type> out;
  for (std::thread& thread : threads_) out.push_back(thread.native_handle());
  return out;
}

void WorkerPool::start_and_wait() {
  if (!threads_.empty()) {
    pending_.store(static_cast<int>(threads_.size()));
    round_.fetch_add(1);
    round_.notify_all();
  }
  do_share(0);
  for (int left = pending_.load(); left != 0; left = pending_.load()) wait_for_change(pending_, left, awake_);
  if (failed_.exchange(false)) {
    failing_.clear();
    std::rethrow_exception(std::exchange(failure_, nullptr));
  }
}

// An exception is kept for who waits: nobody's job may go while another still works on it.
void WorkerPool::do_share(int index) {
  try {
    call_(job_, index);
  } catch (...) {
    if (!failing_.test_and_set()) {
      failure_ = std::current_exception();
      failed_.store(true);
    }
  }
}

void WorkerPool::work(int index) {
  for (unsigned seen = 0;; ++seen) {
    wait_for_change(round_, seen, awake_);
    if (stop_.load()) return;
    do_share(index);
    if (pending_.fetch_sub(1) == 1) pending_.notify_all();
  }
}

}  // namespace cliquevo::stereo
