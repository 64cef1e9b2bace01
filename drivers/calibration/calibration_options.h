// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/base/result.h"

namespace cliquevo::drivers {

// What the user knows better than the file.
struct CalibrationOptions {
  double baseline_unit_m = 0.0;  // metres a unit of the file's lengths; 0 = the format's own, which must be plausible
  bool rectified = false;        // the images are rectified by this calibration already: take its rectified pair
  std::string lens;              // of four distortion terms without a name: plumb_bob, equidistant; empty = by numbers
  double readout_ms = 0.0;       // rolling shutter, from the first row to the last; 0 = all rows at once

  bool empty() const { return baseline_unit_m == 0.0 && !rectified && lens.empty() && readout_ms == 0.0; }
  // Names what is wrong.
  Result<void> check() const;
};

}  // namespace cliquevo::drivers
