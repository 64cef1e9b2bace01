// SPDX-License-Identifier: BSD-3-Clause
#include "tools/option_tree.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "daemon/pipeline/command_line.h"

namespace cliquevo::tools {

namespace {

// CLI11 writes what a value is checked by behind its type: "NAME:{kitti,tum}".
std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> out;
  const std::size_t open = type.find(":{");
  if (open == std::string::npos || !type.ends_with('}')) return out;
  const std::string names = type.substr(open + 2, type.size() - open - 3);
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    out.push_back(names.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

OptionInfo describe_option(const CLI::Option& option) {
  OptionInfo out;
  out.positional = option.get_positional();
  out.name = out.positional ? option.get_single_name() : "--" + option.get_single_name();
  out.required = option.get_required();
  out.meaning = option.get_description();
  if (option.get_type_size() == 0) return out;
  const std::string type = option.get_type_name();
  out.value = type.substr(0, type.find(':'));
  out.choices = choices_of(type);
  if (option.get_expected_min() > 0) {
    out.standard = option.get_default_str();
    std::erase(out.standard, '[');
    std::erase(out.standard, ']');
  }
  return out;
}

CommandInfo describe(const CLI::App& app, const std::string& above) {
  CommandInfo out;
  out.path = above.empty() ? app.get_name() : above + " " + app.get_name();
  out.purpose = app.get_description();
  out.footer = app.get_footer();
  for (const CLI::Option* option : app.get_options({})) out.options.push_back(describe_option(*option));
  for (const CLI::App* command : app.get_subcommands({})) out.commands.push_back(describe(*command, out.path));
  return out;
}

void flatten(const CommandInfo& command, std::vector<const CommandInfo*>& out) {
  out.push_back(&command);
  for (const CommandInfo& below : command.commands) flatten(below, out);
}

}  // namespace

bool OptionInfo::takes_file() const {
  const bool named = value.starts_with("FILE") || value.starts_with("DIR") || value.starts_with("PATH");
  return choices.empty() && (named || positional);
}

CommandInfo describe_app(CliCommand app) { return describe(app.app(), ""); }

CommandInfo describe_daemon(const std::string& version) {
  CLI::App app(daemon::kDaemonPurpose, "cliquevod");
  daemon::DaemonOptions ignored;
  daemon::add_daemon_options(CliCommand(app), ignored);
  app.set_version_flag("--version", version);
  return describe(app, "");
}

std::vector<const CommandInfo*> flattened(const CommandInfo& command) {
  std::vector<const CommandInfo*> out;
  flatten(command, out);
  return out;
}

}  // namespace cliquevo::tools
