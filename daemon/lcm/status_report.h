// SPDX-License-Identifier: BSD-3-Clause
// VO_HEALTH's content as JSON, for `cliquevo ctl status`.
#pragma once

#include <string>

#include <cliquevo/health_t.hpp>

namespace cliquevo::daemon {

// One line; state and state_text, and every other figure under the name that it has in health_t.
std::string status_json(const health_t& health, const std::string& version);

}  // namespace cliquevo::daemon
