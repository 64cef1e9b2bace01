// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

void add_calibrate_command(CLI::App& app, int& exit_code);

}  // namespace cliquevo::tools
