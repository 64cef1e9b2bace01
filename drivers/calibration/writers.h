// SPDX-License-Identifier: BSD-3-Clause
// Calibrations as files that others read, and this program's own reader too.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

struct CalibrationFile {
  std::string path;
  std::string text;
};

struct CalibrationWriter {
  const char* name;     // on the command line
  const char* meaning;  // for --help
  // Fails where the format cannot hold the lens model.
  Result<std::vector<CalibrationFile>> (*write)(const StereoCalibration& calibration, const std::string& path);
};

// A row a format.
std::span<const CalibrationWriter> calibration_writers();
const CalibrationWriter* find_calibration_writer(const std::string& name);

}  // namespace cliquevo::drivers
