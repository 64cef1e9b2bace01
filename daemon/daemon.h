// SPDX-License-Identifier: BSD-3-Clause
// The program behind cliquevod's command line.
#pragma once

#include <string>

namespace cliquevo::daemon {

// The project's table of exit codes.
enum ExitCode : int { kDone = 0, kBadInput = 1, kWrongUsage = 2 };

struct DaemonOptions {
  std::string config;      // file; empty = the compiled defaults
  std::string trajectory;  // file to write; empty = none
};

// Validates configuration and calibration, prints the effective configuration as YAML.
int check(const DaemonOptions& options);
// Runs until the source's end or SIGTERM / SIGINT.
int run(const DaemonOptions& options);

}  // namespace cliquevo::daemon
