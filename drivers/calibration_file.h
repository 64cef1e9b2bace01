// SPDX-License-Identifier: BSD-3-Clause
// Reads stereo calibrations in the formats that drivers/README.md lists.
#pragma once

#include <string>

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "drivers/calibration/calibration_options.h"

namespace cliquevo::drivers {

// path: a file, or a folder that holds the files of both cameras. width, height: of the images it is for (0 = unknown;
// some formats lack it); one of another size is scaled where aspect and principal point fit, else an error.
// What was assumed stands in the calibration's notes.
Result<StereoCalibration> read_calibration(const std::string& path, int width, int height,
                                           const CalibrationOptions& options = {});

}  // namespace cliquevo::drivers
