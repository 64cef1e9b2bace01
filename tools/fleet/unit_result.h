// SPDX-License-Identifier: BSD-3-Clause
// A run as the JSON of its result.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/base/camera_model.h"
#include "tools/comparison.h"
#include "tools/reference.h"
#include "tools/run_log.h"

namespace cliquevo::tools::fleet {

// Only what is the same whenever and wherever it is computed.
nlohmann::json result_json(const RunLog& log, const StereoModel& model, const std::optional<RunReference>& reference,
                           const std::string& trajectory_sha256);

// Median and 95 % of the time a frame took, ms.
nlohmann::json times_json(const RunLog& log);

}  // namespace cliquevo::tools::fleet
