// SPDX-License-Identifier: BSD-3-Clause
// The sub-commands of `cliquevo`, a file each. Each adds itself to the command line; when it is the one chosen, it
// runs while the line is parsed and leaves its exit code.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

inline constexpr const char* kCalibratePurpose =
    "Calibrate a stereo rig from views of a board, or correct it by driving";

void add_replay_command(CLI::App& app, int& exit_code);
void add_eval_command(CLI::App& app, int& exit_code);
void add_calibrate_command(CLI::App& app, int& exit_code);
void add_config_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);
void add_disparity_command(CLI::App& app, int& exit_code);
void add_view_command(CLI::App& app, int& exit_code, const std::string& version);

}  // namespace cliquevo::tools
