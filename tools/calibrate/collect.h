// SPDX-License-Identifier: BSD-3-Clause
// Looks for the board in the pairs of a source, and keeps the views that are worth it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/board_calibration/board.h"
#include "drivers/board_calibration/views.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

struct CollectOptions {
  std::int64_t most_views = 150;
  // Pairs in which the board moves faster are blurred or skewed, and taken only where there are few others; 0: it may
  // have moved, as in a folder of single pictures.
  double most_speed_px_s = 0.0;
  // A view is another one when its corners lie elsewhere by so much of the image's width, on average.
  double news_of_width = 0.03;
};

struct Collected {
  std::vector<calibration::View> views;
  std::int64_t pairs = 0;    // looked at
  std::int64_t without = 0;  // no board in either image
  std::int64_t moving = 0;   // left out: the board moved
  std::int64_t alike = 0;    // left out: as good as a view that is there
  std::string guess;         // what is seen instead of the board, where it never was
  bool stopped = false;      // by a signal
  bool ended = false;        // the source is at its end
  bool enough = false;       // nothing more is wanted
};

Result<Collected> collect_views(drivers::FrameSource& source, const calibration::Board& board,
                                const CollectOptions& options);

}  // namespace cliquevo::tools
