// SPDX-License-Identifier: BSD-3-Clause
// What `cliquevo doctor` looks at.
#pragma once

#include <string>
#include <vector>

namespace cliquevo::tools {

enum class Verdict { good, advice, missing };

struct Finding {
  std::string subject;
  Verdict verdict = Verdict::good;
  std::string found;   // what this machine has
  std::string remedy;  // the command or step that corrects it
};

// config: a configuration file, empty = the defaults. root: where /proc and /sys are looked for (for tests).
std::vector<Finding> examine(const std::string& config, const std::string& root = "");

}  // namespace cliquevo::tools
