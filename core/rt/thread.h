// SPDX-License-Identifier: BSD-3-Clause
// Threads with a name, a core and a real-time priority.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/base/result.h"

namespace cliquevo::rt {

struct ThreadOptions {
  std::string name;       // at most 15 characters are shown by the system
  int cpu = -1;           // core to stay on; -1 = any
  int fifo_priority = 0;  // SCHED_FIFO, 1 to 99; 0 = ordinary time sharing
  std::size_t stack_bytes = std::size_t{1} << 20;
};

// Gives a thread that runs already its name, core and priority. Returns what was not granted, e.g. "FIFO priority 60:
// Operation not permitted"; empty = all was.
std::string schedule(std::thread::native_handle_type thread, const ThreadOptions& options);

// The exit code of a program that a thread ends by an exception.
void exceptions_end_with(int exit_code);

class Thread {
 public:
  Thread() noexcept;  // none
  // Fails only when no thread can be made. Without the right to a priority or the core, the thread runs all the same:
  // shortfall() reports. A body that lets an exception out ends the program: one line on stderr, exit code 1
  // (or that of exceptions_end_with()).
  static Result<Thread> start(const ThreadOptions& options, std::function<void()> body);
  Thread(Thread&&) noexcept;
  Thread& operator=(Thread&&) noexcept;  // joins the one it held
  ~Thread();                             // joins

  void join();
  bool joinable() const { return impl_ != nullptr; }
  // See schedule().
  const std::string& shortfall() const { return shortfall_; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string shortfall_;
};

}  // namespace cliquevo::rt
