// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

// `cliquevo doctor`: what a real-time vehicle needs, what this machine has, and the commands for the difference.
void add_doctor_command(CliCommand app, int& exit_code);

}  // namespace cliquevo::tools
