// SPDX-License-Identifier: BSD-3-Clause
// Text from outside (names of files and devices, values of a configuration, fields of a message), made fit for a
// terminal and a log.
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace cliquevo {

// One line: line breaks and tabs become blanks; other control characters (ESC, C1 also as UTF-8) and what is no UTF-8
// become '?'. Other text stays as it is.
std::string printable(std::string_view text);
// Each of its parts.
Error printable(const Error& error);

}  // namespace cliquevo
