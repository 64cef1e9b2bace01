// SPDX-License-Identifier: BSD-3-Clause
// Where the daemon's lines go: to the journal with their levels when systemd started it, else to stderr.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::daemon {

// level: trace, debug, info, warn, error. Again at any time, while others log.
void set_up_log(const std::string& level);
// One line, `what: where: what to do`, at level error. On a terminal without time or level, as every program prints it.
// In the journal its parts are fields too: CLIQUEVO_WHAT, CLIQUEVO_WHERE, CLIQUEVO_REMEDY.
void report(const Error& error);
// In the journal alone: a line at level info with fields of its own, each with CLIQUEVO_ before its name.
using LogFields = std::vector<std::pair<std::string, std::string>>;
void log_fields(const std::string& line, const LogFields& fields);

}  // namespace cliquevo::daemon
