// SPDX-License-Identifier: BSD-3-Clause
// Where the right camera is, in files that name their matrices: R and T, a transform, each camera's pose, the
// rectifications, a baseline.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/calibration/camera_parts.h"
#include "drivers/calibration/keys.h"

namespace cliquevo::drivers {

struct KeyedPose {
  RigidTransform T_right_left;  // lengths in the file's unit
  // Its direction is certain: a camera that lies on the left is the left one, whatever its name.
  bool directed = false;
  std::string note;  // what was guessed
};

// Nothing = the file has none. `left` and `right`: their rectifications may give the rotation.
Result<std::optional<KeyedPose>> pose_of(const Keys& keys, const CameraParts& left, const CameraParts& right);
// In m: baseline, or bf (of the rectified camera's fx); nothing = neither.
Result<std::optional<double>> baseline_of(const Keys& keys, double fx_px);
// Metres a unit of the file's lengths: by the names of its keys, or by a baseline whose unit is named beside
// `length` in the file's unit. What was inferred is noted.
double length_unit_of(const Keys& keys, double length, std::vector<std::string>& notes);

// Whether the file says the unit of its lengths.
bool names_unit(const Keys& keys);

}  // namespace cliquevo::drivers
