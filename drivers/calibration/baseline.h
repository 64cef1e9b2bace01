// SPDX-License-Identifier: BSD-3-Clause
// Whether a baseline is one of metres: files hold squares of the chessboard, centimetres, millimetres, thousandths.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"

namespace cliquevo::drivers {

// `named`: the unit was named, so the number counts for what it is unless no rig can have it.
Result<void> check_baseline(double baseline_m, bool named, const std::string& where);

// What is said of a baseline that few rigs have, where the file names no unit. A line, or nothing.
std::optional<std::string> note_wide_baseline(double baseline_m);

// With what the images show: the nearest things that a forward-looking rig sees are a few tens of baselines away.
// `near_m`: depth of the nearest matched features by this calibration. A line to print, or nothing.
std::optional<std::string> doubt_baseline(double baseline_m, double near_m);

}  // namespace cliquevo::drivers
