// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

// cliquevo simulate: a course of the simulator as a recording on disk, with its truth.
void add_simulate_command(CLI::App& app, int& exit_code);

}  // namespace cliquevo::tools
