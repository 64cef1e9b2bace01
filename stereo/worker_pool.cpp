// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/worker_pool.h"

namespace cliquevo::stereo {

WorkerPool::WorkerPool(int workers) {
  for (int i = 1; i < workers; ++i) threads_.emplace_back([this, i] { work(i); });
}

WorkerPool::~WorkerPool() {
  stop_.store(true);
  round_.fetch_add(1);
  round_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::start_and_wait() {
  if (!threads_.empty()) {
    pending_.store(static_cast<int>(threads_.size()));
    round_.fetch_add(1);
    round_.notify_all();
  }
  call_(job_, 0);
  for (int left = pending_.load(); left != 0; left = pending_.load()) pending_.wait(left);
}

void WorkerPool::work(int index) {
  for (unsigned seen = 0;; ++seen) {
    round_.wait(seen);
    if (stop_.load()) return;
    call_(job_, index);
    if (pending_.fetch_sub(1) == 1) pending_.notify_all();
  }
}

}  // namespace cliquevo::stereo
