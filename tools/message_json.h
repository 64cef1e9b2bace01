// SPDX-License-Identifier: BSD-3-Clause
// Messages of ours as JSON: every member under its own name.
#pragma once

#include <cstddef>
#include <optional>

#include <nlohmann/json.hpp>

namespace cliquevo::tools {

// The type is recognised by the fingerprint at the message's beginning; none: not one of our types, or damaged. Of
// images the sizes and the camera alone, not the pixels.
std::optional<nlohmann::ordered_json> message_json(const void* data, std::size_t size);

}  // namespace cliquevo::tools
