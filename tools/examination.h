// SPDX-License-Identifier: BSD-3-Clause
// What `cliquevo doctor` looks at.
#pragma once

#include <string>
#include <vector>

#include "daemon/pipeline/command_line.h"

namespace cliquevo::tools {

enum class Verdict { good, advice, missing };

struct Finding {
  std::string subject;
  Verdict verdict = Verdict::good;
  std::string found;   // what this machine has
  std::string remedy;  // the command or step that corrects it
};

// config: as for cliquevod, which without one takes that of /etc/cliquevo. root: where /proc and /sys are looked for
// (for tests).
std::vector<Finding> examine(const daemon::ConfigArgument& config, const std::string& root = "");

}  // namespace cliquevo::tools
