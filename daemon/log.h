// SPDX-License-Identifier: BSD-3-Clause
// Where the daemon's lines go: to the journal with their levels when systemd started it, else to stderr.
#pragma once

#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

// level: trace, debug, info, warn, error. Again at any time, while others log.
void set_up_log(const std::string& level);
// One line, `what: where: what to do`, at level error. On a terminal without time or level, as every program prints it.
void report(const Error& error);

}  // namespace cliquevo::daemon
