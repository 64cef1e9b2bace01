// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

void add_record_command(CliCommand app, int& exit_code);
void add_convert_command(CliCommand app, int& exit_code);

}  // namespace cliquevo::tools
