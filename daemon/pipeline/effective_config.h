// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/pipeline/config.h"

namespace cliquevo::daemon {

// Every key with the value in force, as YAML that reads back to the same configuration.
std::string effective_config_yaml(const Config& config);

}  // namespace cliquevo::daemon
