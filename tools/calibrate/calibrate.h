// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

void add_board_calibration_command(CLI::App& app, int& exit_code, const std::string& version);

}  // namespace cliquevo::tools
