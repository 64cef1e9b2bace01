// SPDX-License-Identifier: BSD-3-Clause
#include "tools/completion.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cliquevo::tools {

namespace {

constexpr const char* kHead = "# SPDX-License-Identifier: BSD-3-Clause\n# Written by `cliquevo config pages`.\n";

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// The first sentence's words are enough beside a list of options.
std::string brief(const std::string& text) { return text.substr(0, std::min(text.find_first_of(":;("), text.size())); }

std::vector<std::string> names_of(const CommandInfo& command) {
  std::vector<std::string> out;
  for (const CommandInfo& below : command.commands) out.push_back(below.name());
  for (const OptionInfo& option : command.options) {
    if (!option.positional) out.push_back(option.name);
    if (option.positional) out.insert(out.end(), option.choices.begin(), option.choices.end());
  }
  return out;
}

// Which command the words before the cursor have reached, in the array `words_of` of either shell.
std::string reached_command(const CompletionWords& words, const std::string& word) {
  std::string out = "    case \"$command " + word + "\" in\n      ";
  std::vector<std::string> paths;
  for (const CommandInfo& program : words.programs) {
    for (const CommandInfo* command : flattened(program)) {
      if (command->path != program.path) paths.push_back("\"" + command->path + "\"");
    }
  }
  return out + fmt::format("{}) command+=\" {}\" ;;\n    esac\n", fmt::join(paths, " | "), word);
}

std::string zsh_action(const OptionInfo& option) {
  if (option.name == "--set") return ":setting:compadd -S '' -- $_cliquevo_settings";
  if (!option.choices.empty()) return fmt::format(":{}:({})", option.value, fmt::join(option.choices, " "));
  if (option.value.empty()) return "";
  return fmt::format(":{}:{}", option.value.substr(0, option.value.find_first_of("|.:")),
                     option.takes_file() ? "_files" : " ");
}

std::string zsh_arguments(const CommandInfo& command) {
  std::vector<std::string> out;
  for (const OptionInfo& option : command.options) {
    if (option.positional) continue;
    std::string meaning = brief(option.meaning);
    std::erase_if(meaning, [](char c) { return c == '[' || c == ']'; });
    out.push_back(in_quotes(fmt::format("*{}[{}]{}", option.name, meaning, zsh_action(option))));
  }
  std::vector<std::string> names;
  for (const CommandInfo& below : command.commands) names.push_back(below.name());
  for (const OptionInfo& option : command.options) {
    if (option.positional) names.insert(names.end(), option.choices.begin(), option.choices.end());
  }
  out.push_back(in_quotes(names.empty() ? "*: :_files" : fmt::format("*: :({})", fmt::join(names, " "))));
  return fmt::format("    {}) _arguments {} ;;\n", in_quotes(command.path), fmt::join(out, " \\\n      "));
}

// True in fish where this command and none below it has been typed.
std::string fish_condition(const CommandInfo& command) {
  std::string out;
  const std::size_t first = command.path.find(' ');
  for (std::size_t begin = first; begin != std::string::npos;) {
    const std::size_t end = command.path.find(' ', begin + 1);
    const std::string name = command.path.substr(begin + 1, end == std::string::npos ? end : end - begin - 1);
    out += fmt::format("{}__fish_seen_subcommand_from {}", out.empty() ? "" : "; and ", name);
    begin = end;
  }
  std::vector<std::string> below;
  for (const CommandInfo& each : command.commands) below.push_back(each.name());
  if (!below.empty()) {
    out += fmt::format("{}not __fish_seen_subcommand_from {}", out.empty() ? "" : "; and ", fmt::join(below, " "));
  }
  return out;
}

std::string fish_option(const std::string& line, const OptionInfo& option) {
  std::string out = fmt::format("{} -l {} -d {}", line, option.name.substr(2), in_quotes(brief(option.meaning)));
  if (option.value.empty()) return out + "\n";
  if (option.name == "--set") return out + " -x -a '$_cliquevo_settings'\n";
  if (!option.choices.empty()) return out + fmt::format(" -x -a '{}'\n", fmt::join(option.choices, " "));
  return out + (option.takes_file() ? " -r -F\n" : " -x\n");
}

std::string fish_command(const CommandInfo& command) {
  const std::string program = command.path.substr(0, command.path.find(' '));
  const std::string condition = fish_condition(command);
  std::string line = "complete -c " + program;
  if (!condition.empty()) line += " -n " + in_quotes(condition);
  std::string out;
  for (const CommandInfo& below : command.commands) {
    out += fmt::format("{} -f -a {} -d {}\n", line, below.name(), in_quotes(brief(below.purpose)));
  }
  for (const OptionInfo& option : command.options) {
    if (!option.positional) out += fish_option(line, option);
    if (!option.choices.empty() && option.positional) {
      out += fmt::format("{} -f -a '{}'\n", line, fmt::join(option.choices, " "));
    }
  }
  return out;
}

}  // namespace

std::string bash_completion(const CompletionWords& words) {
  std::string out = std::string(kHead) + "declare -gA _cliquevo_words _cliquevo_values\n";
  for (const CommandInfo& program : words.programs) {
    for (const CommandInfo* command : flattened(program)) {
      out += fmt::format("_cliquevo_words[{}]={}\n", in_quotes(command->path),
                         in_quotes(fmt::format("{}", fmt::join(names_of(*command), " "))));
      for (const OptionInfo& option : command->options) {
        if (option.positional || option.choices.empty()) continue;
        out += fmt::format("_cliquevo_values[{}]={}\n", in_quotes(command->path + " " + option.name),
                           in_quotes(fmt::format("{}", fmt::join(option.choices, " "))));
      }
    }
  }
  out += fmt::format("_cliquevo_settings={}\n", in_quotes(fmt::format("{}", fmt::join(words.settings, "\n"))));
  out +=
      "_cliquevo() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${1##*/} i key=\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n" +
      reached_command(words, "${COMP_WORDS[i]}") +
      "  done\n"
      "  # bash takes `=` for a word of its own.\n"
      "  if [[ $word == = ]]; then key=$before word=; elif [[ $before == = ]]; then key=${COMP_WORDS[COMP_CWORD - 2]}; "
      "fi\n"
      "  if [[ $key ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$(sed -n \"s/^$key=//p\" <<<\"$_cliquevo_settings\")\" -- \"$word\")\n"
      "  elif [[ $before == --set ]]; then\n"
      "    compopt -o nospace 2>/dev/null\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$_cliquevo_settings\" -- \"$word\")\n"
      "  elif [[ ${_cliquevo_values[$command $before]} ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"${_cliquevo_values[$command $before]}\" -- \"$word\")\n"
      "  elif [[ $before == --* && $word != -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
      "  else\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"${_cliquevo_words[$command]}\" -- \"$word\")\n"
      "    [[ $word == -* ]] || mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -f -- \"$word\")\n"
      "  fi\n"
      "}\n";
  std::vector<std::string> names;
  for (const CommandInfo& program : words.programs) names.push_back(program.path);
  return out + fmt::format("complete -o filenames -F _cliquevo {}\n", fmt::join(names, " "));
}

std::string zsh_completion(const CompletionWords& words) {
  std::vector<std::string> names;
  for (const CommandInfo& program : words.programs) names.push_back(program.path);
  std::string out = fmt::format("#compdef {}\n{}", fmt::join(names, " "), kHead);
  out += fmt::format("typeset -ga _cliquevo_settings=(\n{}\n)\n", fmt::join(words.settings, "\n"));
  out +=
      "_cliquevo() {\n"
      "  local command=${words[1]:t} word\n"
      "  integer i reached=1\n"
      "  for ((i = 2; i < CURRENT; ++i)); do\n"
      "    word=$words[i]\n" +
      reached_command(words, "$word") +
      "    [[ $command == *\" $word\" ]] && reached=i\n"
      "  done\n"
      "  # The command's own words alone are left.\n"
      "  shift $((reached - 1)) words\n"
      "  ((CURRENT -= reached - 1))\n"
      "  case $command in\n";
  for (const CommandInfo& program : words.programs) {
    for (const CommandInfo* command : flattened(program)) out += zsh_arguments(*command);
  }
  return out + "  esac\n}\n_cliquevo \"$@\"\n";
}

std::string fish_completion(const CompletionWords& words) {
  std::string out = std::string(kHead) + fmt::format("set -g _cliquevo_settings {}\n", fmt::join(words.settings, " "));
  for (const CommandInfo& program : words.programs) {
    for (const CommandInfo* command : flattened(program)) out += fish_command(*command);
  }
  return out;
}

}  // namespace cliquevo::tools
