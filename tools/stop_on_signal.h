// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>
#include <cstdint>

namespace cliquevo::tools {

// While it lives, SIGINT and SIGTERM ask for an orderly end; a second one ends the program at once. One at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool received();
  // Sleeps until monotonic_ns() is so far, or it is asked to stop.
  static void sleep_until(std::int64_t due_mono_ns);

 private:
  struct sigaction old_interrupt_ = {};
  struct sigaction old_terminate_ = {};
};

}  // namespace cliquevo::tools
