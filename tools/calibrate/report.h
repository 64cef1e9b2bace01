// SPDX-License-Identifier: BSD-3-Clause
// A calibration as a page: one file that opens from disk.
#pragma once

#include <string>

#include "tools/calibrate/summary.h"

namespace cliquevo::tools {

std::string calibration_report(const CalibrationResult& result);

}  // namespace cliquevo::tools
