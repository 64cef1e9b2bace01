// SPDX-License-Identifier: BSD-3-Clause
// How far a board has moved in the image from one look to the next.
#pragma once

#include <optional>
#include <vector>

#include "drivers/board_calibration/views.h"

namespace cliquevo::tools {

// Mean distance of the corners that both have; none where they share fewer than half.
std::optional<double> moved_px(const std::vector<calibration::SeenCorner>& a,
                               const std::vector<calibration::SeenCorner>& b);

}  // namespace cliquevo::tools
