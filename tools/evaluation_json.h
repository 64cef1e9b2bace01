// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "tools/evaluation.h"

namespace cliquevo::tools {

// What `cliquevo eval --json` prints; null where there is nothing to average.
nlohmann::json to_json(const Evaluation& evaluation);
std::string evaluation_json(const Evaluation& evaluation);

}  // namespace cliquevo::tools
