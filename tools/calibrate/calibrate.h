// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

void add_board_calibration_command(CliCommand app, int& exit_code, const std::string& version);

}  // namespace cliquevo::tools
