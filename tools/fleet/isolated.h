// SPDX-License-Identifier: BSD-3-Clause
// Work in a process of its own, so that a crash ends nothing else.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/base/result.h"

namespace cliquevo::tools::fleet {

struct IsolatedEnd {
  std::optional<Error> error;  // the work's own, or that it crashed
  bool crashed = false;        // a signal, or an exit that the work did not choose
  std::string said;            // the last of what it printed, a few kB
};

// Runs `work` in a child process that ends with this one, and waits. What it prints is kept, not shown. SIGTERM and
// SIGINT to this process go on to it, where a StopOnSignal lives here. Only while this process has one thread.
// where: for the message of a crash.
IsolatedEnd run_isolated(const std::function<Result<void>()>& work, const Error& crash);

}  // namespace cliquevo::tools::fleet
