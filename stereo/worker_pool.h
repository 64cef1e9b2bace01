// SPDX-License-Identifier: BSD-3-Clause
// Threads that share the rows of one image: started once, asleep between images, no lock and no allocation a call.
#pragma once

#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace cliquevo::stereo {

class WorkerPool {
 public:
  // workers: threads in all, the caller's included; 1 starts none.
  explicit WorkerPool(int workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int workers() const { return static_cast<int>(threads_.size()) + 1; }

  // Of the threads beside the caller's.
  std::vector<std::thread::native_handle_type> handles();

  // Calls job(0) ... job(workers() - 1), one on each thread, and returns when all are done. What one of
  // them throws comes out then.
  template <class Job>
  void run(Job&& job) {
    call_ = [](void* of, int index) { (*static_cast<std::remove_reference_t<Job>*>(of))(index); };
    job_ = &job;
    start_and_wait();
  }

 private:
  void start_and_wait();
  void do_share(int index);
  void work(int index);

  const bool awake_;  // whether threads wait awake for a moment: not where they would take each other's cores
  void (*call_)(void*, int) = nullptr;
  void* job_ = nullptr;
  std::atomic<unsigned> round_{0};
  std::atomic<int> pending_{0};
  std::atomic<bool> stop_{false};
  std::atomic_flag failing_;  // taken by the first share that throws
  std::atomic<bool> failed_{false};
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace cliquevo::stereo
