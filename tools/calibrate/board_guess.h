// SPDX-License-Identifier: BSD-3-Clause
// What may be in an image where the board that was named is not.
#pragma once

#include <string>

#include "tools/calibrate/detector.h"

namespace cliquevo::tools {

// A sentence ("8x5 corners are seen, 9x6 were named"); empty: nothing that is known.
std::string guess_board(const calibration::Board& board, const BoardDetector& detector,
                        ImageView<const std::uint8_t> image);

}  // namespace cliquevo::tools
