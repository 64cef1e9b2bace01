// SPDX-License-Identifier: BSD-3-Clause
// Detects times in which the machine did not run what was ready to run: for tests that depend on that.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <pthread.h>
#include <sched.h>
#include <thread>
#include <vector>

namespace cliquevo::test {

class StallWatch {
 public:
  struct Stall {
    std::int64_t begin_us = 0;  // UTC
    std::int64_t end_us = 0;
  };

  // fifo_priority: of its threads, where the rights are there; 0 = ordinary.
  explicit StallWatch(std::int64_t worth_telling_us, int fifo_priority = 0)
      : worth_telling_us_(worth_telling_us), fifo_priority_(fifo_priority) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    ::sched_getaffinity(0, sizeof cpus, &cpus);
    found_.resize(CPU_SETSIZE);
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (CPU_ISSET(cpu, &cpus)) threads_.emplace_back([this, cpu] { watch(cpu); });
    }
  }
  ~StallWatch() { stop(); }
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  std::vector<Stall> stop() {
    done_ = true;
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
    std::vector<Stall> out;
    for (const auto& of_cpu : found_) out.insert(out.end(), of_cpu.begin(), of_cpu.end());
    return out;
  }

 private:
  static std::int64_t now_us() {
    return std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  void watch(int cpu) {
    cpu_set_t mine;
    CPU_ZERO(&mine);
    CPU_SET(cpu, &mine);
    ::sched_setaffinity(0, sizeof mine, &mine);
    const sched_param priority{fifo_priority_};
    if (fifo_priority_ > 0) ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
    while (!done_) {
      const std::int64_t begin_us = now_us();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const std::int64_t end_us = now_us();
      if (end_us - begin_us > worth_telling_us_) found_[static_cast<std::size_t>(cpu)].push_back({begin_us, end_us});
    }
  }

  std::int64_t worth_telling_us_;
  int fifo_priority_;
  std::vector<std::vector<Stall>> found_;  // by CPU
  std::atomic<bool> done_{false};
  std::vector<std::thread> threads_;
};

}  // namespace cliquevo::test
