// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

// `cliquevo doctor`: what a real-time vehicle needs, what this machine has, and the commands for the difference.
void add_doctor_command(CLI::App& app, int& exit_code);

}  // namespace cliquevo::tools
