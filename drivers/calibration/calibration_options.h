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

  bool empty() const { return baseline_unit_m == 0.0 && !rectified && lens.empty(); }
  // Names what is wrong.
  Result<void> check() const;
};

}  // namespace cliquevo::drivers
