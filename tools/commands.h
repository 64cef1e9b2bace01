// SPDX-License-Identifier: BSD-3-Clause
// The sub-commands of `cliquevo`, a file each. Each adds itself to the command line; when it is the one chosen, it
// runs while the line is parsed and leaves its exit code.
#pragma once

#include <string>

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

void add_replay_command(CliCommand app, int& exit_code);
void add_eval_command(CliCommand app, int& exit_code);
void add_config_command(CliCommand app, int& exit_code);
void add_compare_command(CliCommand app, int& exit_code);
void add_info_command(CliCommand app, int& exit_code);
void add_mavlink_command(CliCommand app, int& exit_code);
void add_ros2_command(CliCommand app, int& exit_code);
void add_disparity_command(CliCommand app, int& exit_code);
void add_echo_command(CliCommand app, int& exit_code);
void add_watch_command(CliCommand app, int& exit_code);

// Only in a program that can draw (tools/drawing.h).
inline constexpr const char* kCalibratePurpose =
    "Calibrate a stereo rig from views of a board, or correct it by driving";
inline constexpr const char* kViewPurpose = "See what it sees: a page for the browser, live or of a recording";
void add_view_command(CliCommand app, int& exit_code, const std::string& version);

}  // namespace cliquevo::tools
