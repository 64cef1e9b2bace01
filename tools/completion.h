// SPDX-License-Identifier: BSD-3-Clause
// What shells complete the programs' command lines by.
#pragma once

#include <string>
#include <vector>

#include "tools/option_tree.h"

namespace cliquevo::tools {

struct CompletionWords {
  std::vector<CommandInfo> programs;
  std::vector<std::string> settings;  // what may stand behind --set: "source.type=simulator", "source.speed="
};

std::string bash_completion(const CompletionWords& words);
std::string zsh_completion(const CompletionWords& words);
std::string fish_completion(const CompletionWords& words);

}  // namespace cliquevo::tools
