// SPDX-License-Identifier: BSD-3-Clause
// Corners of a board as exactly as the image shows them.
#pragma once

#include <vector>

#include "core/base/image.h"
#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/views.h"

namespace cliquevo::tools {

// Of a board whose corners are where dark and bright quarters meet: all kinds but circles. Corners begin within half a
// pixel; one that shows another pattern stays where it is.
void refine_corners(ImageView<const std::uint8_t> image, const calibration::Board& board,
                    std::vector<calibration::SeenCorner>& corners);

}  // namespace cliquevo::tools
