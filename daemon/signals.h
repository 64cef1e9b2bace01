// SPDX-License-Identifier: BSD-3-Clause
// Signals as events: blocked in every thread, taken by the main one.
#pragma once

#include <csignal>
#include <cstdint>

namespace cliquevo::daemon {

class Signals {
 public:
  // Before any thread is started: they inherit the mask. SIGPIPE is ignored: a lost LCM server is an error of
  // publish().
  Signals();
  // The next of SIGTERM, SIGINT, SIGHUP; 0 after timeout_ns without one.
  int wait(std::int64_t timeout_ns) const;

 private:
  sigset_t set_{};
};

}  // namespace cliquevo::daemon
