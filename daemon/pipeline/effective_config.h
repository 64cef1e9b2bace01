// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/pipeline/config.h"

namespace cliquevo::daemon {

// Every key with the value in force, as YAML that reads back to the same configuration.
std::string effective_config_yaml(const Config& config);
// A JSON object: the same keys in sections, and what the source is.
std::string effective_config_json(const Config& config, const std::string& source);

}  // namespace cliquevo::daemon
