// SPDX-License-Identifier: BSD-3-Clause
// What pages call checks and verdicts, and how they explain them.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace cliquevo::view {

// {"checks": [name, ...], "check_texts": [{"unit", "meaning"}, ...], "verdicts": [name, ...]}, by their numbers.
nlohmann::json check_words();

}  // namespace cliquevo::view
