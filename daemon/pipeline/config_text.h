// SPDX-License-Identifier: BSD-3-Clause
// A configuration's text, looked at before it is taken apart: a file may be large, endless, or made to be costly.
#pragma once

#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

// The shipped file with all its comments has some 20 000 bytes.
inline constexpr std::size_t kLargestConfig = 256 * 1024;

// The file's bytes; fails for what is no file or device, and beyond kLargestConfig.
Result<std::string> read_config_text(const std::string& path);
// That it is YAML, not deeply nested, and without aliases: a few lines of them stand for more than any memory holds.
Result<void> check_config_text(const std::string& text, const std::string& path);

}  // namespace cliquevo::daemon
