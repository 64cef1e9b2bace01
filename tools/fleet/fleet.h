// SPDX-License-Identifier: BSD-3-Clause
// cliquevo fleet: plan, run, status, report, and run-unit, which a node executes.
#pragma once

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools::fleet {

void add_fleet_command(CliCommand app, int& exit_code);

}  // namespace cliquevo::tools::fleet
