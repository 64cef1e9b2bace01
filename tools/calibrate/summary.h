// SPDX-License-Identifier: BSD-3-Clause
// A calibration in words, and as JSON.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "drivers/board_calibration/accuracy.h"
#include "drivers/board_calibration/solve.h"
#include "tools/calibrate/collect.h"
#include "tools/calibrate/from_driving.h"

namespace cliquevo::tools {

struct CalibrationResult {
  calibration::Board board;
  calibration::Solution solution;
  calibration::Accuracy accuracy;
  calibration::Coverage coverage;
  std::optional<calibration::Movement> movement;  // against --compare
  std::string compared_with;
  Collected collected;
};

nlohmann::json to_json(const CalibrationResult& result);
std::string summary_of(const CalibrationResult& result);

nlohmann::json to_json(const DrivenCalibration& driven);
std::string summary_of(const DrivenCalibration& driven);

}  // namespace cliquevo::tools
