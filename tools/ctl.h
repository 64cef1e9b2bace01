// SPDX-License-Identifier: BSD-3-Clause
// cliquevo ctl: commands to the running daemon, and its status.
#pragma once

#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

void add_ctl_command(CliCommand app, int& exit_code);

// The daemon's status, JSON in one line, as some lines for people.
Result<std::string> status_summary(const std::string& json);

}  // namespace cliquevo::tools
