// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

// `cliquevo spy`: lcm-spy with our message types, so that every field shows.
void add_spy_command(CliCommand app, int& exit_code);

}  // namespace cliquevo::tools
