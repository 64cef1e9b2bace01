// SPDX-License-Identifier: BSD-3-Clause
#include "tools/exit_code.h"

#include <string>

#include "core/base/standard_streams.h"

namespace cliquevo::tools {

int report(const Error& error, ExitCode code) {
  print_error_line(error.line());
  return code;
}

void warn(const Error& error) { print_error_line("warning: " + error.line()); }

}  // namespace cliquevo::tools
