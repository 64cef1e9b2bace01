// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/result.h"
#include "daemon/output.h"
#include "daemon/pipeline/config.h"
#include "daemon/recording.h"

namespace cliquevo::daemon {

// path: empty = the compiled defaults.
Result<Config> load_config(const std::string& path);

// SIGHUP: reads the configuration again. What can change while running does, what cannot is named.
void reload(const std::string& path, Config& in_force, Output& output, Recording& recording);

}  // namespace cliquevo::daemon
