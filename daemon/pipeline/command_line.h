// SPDX-License-Identifier: BSD-3-Clause
// The options of command lines that name a configuration, and those of cliquevod: here, below the daemon and the tools,
// so that man pages and completion can be written from both.
#pragma once

#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/cli_command.h"
#include "daemon/pipeline/config.h"

namespace cliquevo::daemon {

// What --config and --set name.
struct ConfigArgument {
  std::string file;
  std::vector<std::string> settings;
  bool needs_calibration = true;  // as in ConfigSources

  bool empty() const { return file.empty() && settings.empty(); }
};

// --config and --set; `file_meaning` is the help of the first.
void add_config_options(CliCommand app, ConfigArgument& argument, const std::string& file_meaning);
// The compiled defaults with the argument on top.
Result<Config> read_config(const ConfigArgument& argument);

// The folder in which the daemon looks for its configuration without --config.
inline constexpr const char* kConfigFolder = "/etc/cliquevo";
// The folder's cliquevo.yaml, then cliquevo.yaml.d/*.yaml in the order of their names; those that exist.
std::vector<std::string> config_files_in(const std::string& folder);

inline constexpr const char* kDaemonPurpose =
    "Stereo visual odometry as a daemon: grabs stereo pairs and sends poses over LCM.";

struct DaemonOptions {
  ConfigArgument config;
  std::string trajectory;  // file to write; empty = none
  bool check = false;      // validate and print, do not run
  bool json = false;       // of the check
};

void add_daemon_options(CliCommand app, DaemonOptions& options);
// Without --config: what is found in the folder.
Result<Config> read_daemon_config(const ConfigArgument& argument, const std::string& folder = kConfigFolder);

}  // namespace cliquevo::daemon
