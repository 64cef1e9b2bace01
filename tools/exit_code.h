// SPDX-License-Identifier: BSD-3-Clause
// Meaning of the program's exit codes, whichever sub-command ran.
#pragma once

#include "core/base/result.h"

namespace cliquevo::tools {

enum ExitCode : int {
  kDone = 0,
  kBadInput = 1,         // bad input or environment
  kWrongUsage = 2,       // of the command line
  kNotStrictEnough = 3,  // done, but short of the required strictness
};

// One line on stderr, `what: where: what to do`; returns `code`.
int report(const Error& error, ExitCode code = kBadInput);
// "warning: ..." on stderr.
void warn(const Error& error);

}  // namespace cliquevo::tools
