// SPDX-License-Identifier: BSD-3-Clause
#include "tools/exit_code.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

void print_line(const char* before, const Error& error) {
  std::string line = error.line();
  std::replace(line.begin(), line.end(), '\n', ' ');  // one error, one line, whatever a library said
  fmt::print(stderr, "{}{}\n", before, line);
}

}  // namespace

int report(const Error& error, ExitCode code) {
  print_line("", error);
  return code;
}

void warn(const Error& error) { print_line("warning: ", error); }

}  // namespace cliquevo::tools
