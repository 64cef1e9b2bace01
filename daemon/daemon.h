// SPDX-License-Identifier: BSD-3-Clause
// The program behind cliquevod's command line.
#pragma once

#include "daemon/pipeline/command_line.h"

namespace cliquevo::daemon {

// The project's table of exit codes.
// kStartAgain: of a service alone, after what another start may cure; the unit restarts it, as it does not after 1
// and 2.
enum ExitCode : int { kDone = 0, kBadInput = 1, kWrongUsage = 2, kStartAgain = 75 };
// The code of an end that no input explains: no memory left, a library at its end, a stage that failed on live images.
int unexpected_end();

// Validates configuration and calibration, prints the effective configuration as YAML, or as JSON.
int check(const DaemonOptions& options);
// Runs until the source's end or SIGTERM / SIGINT.
int run(const DaemonOptions& options);

}  // namespace cliquevo::daemon
