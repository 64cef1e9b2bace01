// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/comparison.h"

namespace cliquevo::tools::fleet {

struct ReportArguments {
  std::string out;
  std::string baseline;
  Gates gates;
  int pages = 5;
  bool json = false;
};

// fleet report: its exit code.
int run_report_command(const ReportArguments& arguments);

}  // namespace cliquevo::tools::fleet
