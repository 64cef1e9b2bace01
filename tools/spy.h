// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

// `cliquevo spy`: lcm-spy with our message types, so that every field shows.
void add_spy_command(CLI::App& app, int& exit_code);

}  // namespace cliquevo::tools
