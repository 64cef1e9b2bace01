// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

// cliquevo simulate: a course of the simulator as a recording on disk, with its truth.
void add_simulate_command(CliCommand app, int& exit_code);

}  // namespace cliquevo::tools
