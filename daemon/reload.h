// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/result.h"
#include "daemon/output.h"
#include "daemon/pipeline/command_line.h"
#include "daemon/recording.h"

namespace cliquevo::daemon {

// SIGHUP: reads the configuration again. What can change while running does, what cannot is named.
void reload(const ConfigArgument& source, Config& in_force, Output& output, Recording& recording);

}  // namespace cliquevo::daemon
