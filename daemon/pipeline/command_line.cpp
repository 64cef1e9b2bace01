// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/command_line.h"

#include <algorithm>
#include <filesystem>

namespace cliquevo::daemon {

namespace fs = std::filesystem;

void add_config_options(CliCommand app, ConfigArgument& argument, const std::string& file_meaning) {
  app.add_option("--config", argument.file, file_meaning).type_name("FILE");
  app.add_option("--set", argument.settings,
                 "Set one key, after --config: section.key=value, as in the file; may be given again")
      .repeatable()
      .type_name("KEY=VALUE");
}

Result<Config> read_config(const ConfigArgument& argument) {
  ConfigSources sources{{}, argument.settings, argument.needs_calibration};
  if (!argument.file.empty()) sources.files.push_back(argument.file);
  return read_config(sources);
}

std::vector<std::string> config_files_in(const std::string& folder) {
  const fs::path file = fs::path(folder) / "cliquevo.yaml";
  std::vector<std::string> out;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(file.string() + ".d", none)) {
    if (entry.path().extension() == ".yaml") out.push_back(entry.path());
  }
  std::sort(out.begin(), out.end());
  if (fs::exists(file, none)) out.insert(out.begin(), file);
  return out;
}

void add_daemon_options(CliCommand app, DaemonOptions& options) {
  add_config_options(app, options.config,
                     "Configuration file (default: /etc/cliquevo/cliquevo.yaml and cliquevo.yaml.d/*.yaml beside it)");
  app.add_flag("--check", options.check, "Validate configuration and calibration, print what is in force, and end");
  app.add_flag("--json", options.json, "With --check: print JSON");
  app.add_option("--trajectory", options.trajectory, "Write the camera's poses here (KITTI format)").type_name("FILE");
  app.footer(
      "Exit codes: 0 done; 1 bad input or environment; 2 wrong usage.\n"
      "SIGTERM and SIGINT stop it cleanly: frames on their way still go out.");
}

Result<Config> read_daemon_config(const ConfigArgument& argument, const std::string& folder) {
  if (!argument.file.empty()) return read_config(argument);
  return read_config(ConfigSources{config_files_in(folder), argument.settings, argument.needs_calibration});
}

}  // namespace cliquevo::daemon
