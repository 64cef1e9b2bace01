// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <csignal>

namespace cliquevo::tools {

// While it lives, SIGINT and SIGTERM ask for an orderly end; a second one ends the program at once. One at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool asked();

 private:
  struct sigaction old_interrupt_ = {};
  struct sigaction old_terminate_ = {};
};

}  // namespace cliquevo::tools
