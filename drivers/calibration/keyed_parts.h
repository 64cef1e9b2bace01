// SPDX-License-Identifier: BSD-3-Clause
// What files that name their matrices hold of a camera, by the meaning of their keys.
#pragma once

#include <optional>
#include <string>

#include "drivers/calibration/camera_parts.h"
#include "drivers/calibration/keys.h"

namespace cliquevo::drivers {

// The single number of this side, else the one for both cameras; nothing = there is none.
Result<std::optional<double>> number_of(const Keys& keys, Quantity quantity, KeySide side, int index = 0);
// fx, fy, cx, cy as numbers of their own; false: there are none.
Result<bool> read_focal_lengths(const Keys& keys, KeySide side, CameraCalibration& camera);
// Matrix, lens, size, projection and rectification of one camera; what is not there stays empty.
Result<CameraParts> read_parts(const Keys& keys, KeySide side, const std::string& path);

}  // namespace cliquevo::drivers
