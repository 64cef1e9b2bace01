// SPDX-License-Identifier: BSD-3-Clause
// A program's command line as data: what man pages and completion are written from.
#pragma once

#include <string>
#include <vector>

#include "daemon/pipeline/cli_command.h"

namespace cliquevo::tools {

struct OptionInfo {
  std::string name;                  // "--config", or a positional's "SOURCE"
  std::string value;                 // "FILE"; empty: it takes none
  std::vector<std::string> choices;  // of the value; empty: any
  std::string meaning;
  std::string standard;  // default, empty = none
  bool positional = false;
  bool required = false;

  bool takes_file() const;
};

struct CommandInfo {
  std::string path;  // "cliquevo cameras test"
  std::string purpose;
  std::string footer;
  std::vector<OptionInfo> options;  // positionals too, in their order
  std::vector<CommandInfo> commands;

  std::string name() const { return path.substr(path.rfind(' ') + 1); }
};

CommandInfo describe_app(CliCommand app);
// cliquevod's.
CommandInfo describe_daemon(const std::string& version);
// The command, then those below it, in the order in which --help lists them.
std::vector<const CommandInfo*> flattened(const CommandInfo& command);

}  // namespace cliquevo::tools
