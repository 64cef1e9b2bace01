// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/smoothing.h"

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

void Smoother::smooth_across(const kernels::Table& kernel, int y) {
  kernels::SmoothRow across{padded_.data() + radius_, {}, 2 * radius_, kDisparityScale, kFiner, 0, 0};
  for (int i = 0; i < radius_; ++i) {
    across.neighbour[2 * i] = across.centre - (i + 1);
    across.neighbour[2 * i + 1] = across.centre + (i + 1);
  }
  kernel.smooth_row(across, lines_.width(), line(y));
}

void Smoother::smooth_down(const kernels::Table& kernel, int y, int height, std::int16_t* out) {
  kernels::SmoothRow down{line(y), {}, 2 * radius_, kDisparityScale * kFiner, 1, kFiner / 2, 2};
  for (int i = 0; i < radius_; ++i) {
    const int above = y - (i + 1);
    const int below = y + (i + 1);
    down.neighbour[2 * i] = above >= 0 ? line(above) : unknown_.data();
    down.neighbour[2 * i + 1] = below < height ? line(below) : unknown_.data();
  }
  kernel.smooth_row(down, lines_.width(), out);
}

}  // namespace cliquevo::stereo
