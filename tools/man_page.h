// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tools/option_tree.h"

namespace cliquevo::tools {

// The page for man(1) on a program with all its commands. section: 1 (commands) or 8 (administration).
std::string man_page(const CommandInfo& program, int section, const std::string& version);

}  // namespace cliquevo::tools
