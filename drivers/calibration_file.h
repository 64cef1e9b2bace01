// SPDX-License-Identifier: BSD-3-Clause
// Reads stereo calibrations in the formats that drivers/README.md lists.
#pragma once

#include <string>

#include "core/base/camera_model.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

// What the user knows better than the file.
struct CalibrationOptions {
  double baseline_unit_m = 0.0;  // metres a unit of the file's lengths; 0 = the format's own, which must be plausible
  bool rectified = false;        // the images are rectified by this calibration already: take its rectified pair
  std::string lens;              // of four distortion terms without a name: plumb_bob, equidistant; empty = by numbers

  bool empty() const { return baseline_unit_m == 0.0 && !rectified && lens.empty(); }
  // Names what is wrong.
  Result<void> check() const;
};

// path: a file, or a folder that holds the files of both eyes. width, height: of the images it is for (0 = unknown;
// some formats do not tell); one of another size is scaled where aspect and principal point say so, else an error.
// What was assumed stands in the calibration's notes.
Result<StereoCalibration> read_calibration(const std::string& path, int width, int height,
                                           const CalibrationOptions& options = {});

}  // namespace cliquevo::drivers
