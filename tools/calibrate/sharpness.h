// SPDX-License-Identifier: BSD-3-Clause
// How sharp a board is in an image.
#pragma once

#include <vector>

#include "core/base/image.h"
#include "drivers/board_calibration/views.h"

namespace cliquevo::tools {

// Width of the edges about the corners, px, in the direction in which they are widest; the median over the corners. A
// sharp picture has 2 to 3, a Gaussian blur of sigma s adds 3.5 s. 0 where no corner is far enough from the border.
double edge_width_px(ImageView<const std::uint8_t> image, const std::vector<calibration::SeenCorner>& corners);

}  // namespace cliquevo::tools
