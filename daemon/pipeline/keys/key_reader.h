// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <yaml-cpp/yaml.h>

#include "daemon/pipeline/keys/key.h"

namespace cliquevo::daemon {

// Sets the key to what stands in the file. false: it is not what the key expects (Key::expects()), and nothing changed.
// folder: where relative paths start.
bool read_value(const Key& key, const YAML::Node& node, const std::string& folder);

}  // namespace cliquevo::daemon
