// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/smoothing.h"

#include <algorithm>

namespace cliquevo::stereo {

namespace {

constexpr int kFiner = 4;  // between both passes, so that rounding twice costs nothing

}  // namespace

void Smoother::prepare(int width, int radius) {
  radius_ = radius;
  padded_.assign(static_cast<std::size_t>(width) + 2 * static_cast<std::size_t>(radius), kUnknownDisparity);
  unknown_.assign(static_cast<std::size_t>(width), kUnknownDisparity);
  lines_.resize(width, 2 * radius + 1);
}

void Smoother::smooth(const kernels::Table& kernel, ImageView<std::int16_t> disparity) {
  kernels::SmoothRow across{padded_.data() + radius_, {}, 2 * radius_, kDisparityScale, kFiner, 0, 0};
  for (int i = 0; i < radius_; ++i) {
    across.neighbour[2 * i] = across.centre - (i + 1);
    across.neighbour[2 * i + 1] = across.centre + (i + 1);
  }
  // A row is overwritten once all rows that its column needs have been read.
  for (int y = 0; y < disparity.height + radius_; ++y) {
    if (y < disparity.height) {
      std::copy(disparity.row(y), disparity.row(y) + disparity.width, padded_.data() + radius_);
      kernel.smooth_row(across, disparity.width, line(y));
    }
    const int done = y - radius_;
    if (done < 0) continue;
    kernels::SmoothRow down{line(done), {}, 2 * radius_, kDisparityScale * kFiner, 1, kFiner / 2, 2};
    for (int i = 0; i < radius_; ++i) {
      const int above = done - (i + 1);
      const int below = done + (i + 1);
      down.neighbour[2 * i] = above >= 0 ? line(above) : unknown_.data();
      down.neighbour[2 * i + 1] = below < disparity.height ? line(below) : unknown_.data();
    }
    kernel.smooth_row(down, disparity.width, disparity.row(done));
  }
}

}  // namespace cliquevo::stereo
