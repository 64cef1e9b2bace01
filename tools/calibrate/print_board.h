// SPDX-License-Identifier: BSD-3-Clause
// A calibration board to print, at true scale.
#pragma once

#include <string>

#include "core/base/result.h"
#include "drivers/board_calibration/board.h"

namespace cliquevo::tools {

// path: .pdf or .svg. The page is as large as the board with its border and a ruler of 100 mm below it.
Result<void> print_board(const calibration::Board& board, const std::string& path);

}  // namespace cliquevo::tools
