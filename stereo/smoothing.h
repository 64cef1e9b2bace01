// SPDX-License-Identifier: BSD-3-Clause
// Smoothing: neighbouring windows overlap, but not their noise entirely, and their sub-pixel fits lean to whole pixels
// in different ways; a mean over neighbours of the same surface takes part of both away.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo {

class Smoother {
 public:
  void prepare(int width, int radius);
  // Each known disparity becomes the mean over its row, then over its column, of the known ones at most `radius` px
  // away whose disparity differs by at most 1 px. Unknown ones stay unknown.
  void smooth(const kernels::Table& kernel, ImageView<std::int16_t> disparity);

 private:
  std::int16_t* line(int y) { return lines_.view().row(y % (2 * radius_ + 1)); }

  int radius_ = 0;
  std::vector<std::int16_t> padded_;  // a row with unknown neighbours on both sides
  std::vector<std::int16_t> unknown_;
  Image<std::int16_t> lines_;  // rows smoothed across, px * 64
};

}  // namespace cliquevo::stereo
