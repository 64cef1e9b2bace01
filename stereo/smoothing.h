// SPDX-License-Identifier: BSD-3-Clause
// Smoothing: neighbouring windows overlap, but not their noise entirely, and their sub-pixel fits lean to whole pixels
// in different ways; a mean over neighbours of the same surface takes part of both away.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo {

// Each worker has one.
class Smoother {
 public:
  void prepare(int width, int radius);
  // Rows [begin, end) of `in`, once clean(y, row) has been over each, to those of `out`: each known disparity becomes
  // the mean over its row, then over its column, of the known ones at most `radius` px away whose disparity differs by
  // at most 1 px. Unknown ones stay unknown.
  template <typename Clean>
  void smooth(const kernels::Table& kernel, ImageView<const std::int16_t> in, int begin, int end, const Clean& clean,
              ImageView<std::int16_t> out) {
    for (int y = begin; radius_ == 0 && y < end; ++y) {
      std::copy(in.row(y), in.row(y) + in.width, out.row(y));
      clean(y, out.row(y));
    }
    for (int y = std::max(begin - radius_, 0); radius_ > 0 && y < end + radius_; ++y) {
      if (y < in.height) {
        std::int16_t* const row = padded_.data() + radius_;
        std::copy(in.row(y), in.row(y) + in.width, row);
        clean(y, row);
        smooth_across(kernel, y);
      }
      // The last row that the column of this one needs has just been read.
      if (y - radius_ >= begin) smooth_down(kernel, y - radius_, in.height, out.row(y - radius_));
    }
  }

 private:
  std::int16_t* line(int y) { return lines_.view().row(y % (2 * radius_ + 1)); }
  void smooth_across(const kernels::Table& kernel, int y);
  void smooth_down(const kernels::Table& kernel, int y, int height, std::int16_t* out);

  int radius_ = 0;
  std::vector<std::int16_t> padded_;  // a row with unknown neighbours on both sides
  std::vector<std::int16_t> unknown_;
  Image<std::int16_t> lines_;  // rows smoothed across, px * 64
};

}  // namespace cliquevo::stereo
