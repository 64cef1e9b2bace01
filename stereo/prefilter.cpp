// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/prefilter.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::stereo {

namespace {

int range_of(const StereoParams& params) {
  return kernels::matching_range(params.window, params.window_height, params.num_disparities);
}

std::uint16_t slope(double per_grey_level) { return static_cast<std::uint16_t>(std::lround(per_grey_level * 4096.0)); }

}  // namespace

void MatchingImage::prepare(int width, int height) {
  storage_.resize(width + 2 * kernels::kMargin, height);
  storage_.fill(0);
}

void MatchingPair::prepare(int width, int height) {
  left.prepare(width, height);
  for (MatchingImage& image : right) image.prepare(width, height);
}

kernels::Curve matching_curve(const StereoParams& params) {
  const int range = range_of(params);
  if (params.prefilter == Prefilter::gradients) {
    // About range * v / (v + 20): twice the noise of a usual camera comes to half the range, and the gradients of
    // strong edges, which differ most between the cameras, do not drown all else.
    return {{12, 40, 160}, {slope(range * 0.0365), slope(range * 0.0121), slope(range * 0.00232)}, range};
  }
  const int cap = params.prefilter_cap;
  return {{static_cast<std::uint16_t>(cap), 0, 0}, {slope(static_cast<double>(range) / cap), 0, 0}, range};
}

kernels::Channels matching_channels(const StereoParams& params) {
  return params.prefilter == Prefilter::gradients ? kernels::Channels::checkered : kernels::Channels::horizontal;
}

void prefilter_rows(const kernels::Table& kernel, const StereoParams& params, ImageView<const std::uint8_t> left,
                    ImageView<const std::uint8_t> right, int begin, int end, ImageView<std::uint8_t> filtered,
                    MatchingPair& matching) {
  const kernels::Curve curve = matching_curve(params);
  const kernels::Channels channels = matching_channels(params);
  const auto rows = [&curve](ImageView<const std::uint8_t> image, int y) {
    return kernels::PrefilterRow{image.row(std::max(y - 1, 0)), image.row(y),
                                 image.row(std::min(y + 1, image.height - 1)), image.width, curve};
  };
  for (int y = begin; y < end; ++y) {
    kernel.prefilter_left(rows(left, y), channels, y, params.prefilter_cap, filtered.row(y), matching.left.row(y));
    kernel.prefilter_right(rows(right, y), matching.right[0].row(y), matching.right[1].row(y));
    if (params.prefilter == Prefilter::none) {
      const int levels = 2 * curve.range + 1;
      for (int x = 0; x < left.width; ++x) {
        matching.left.row(y)[x] = static_cast<std::uint8_t>(left(x, y) * levels >> 8);
        matching.right[0].row(y)[x] = static_cast<std::uint8_t>(right(x, y) * levels >> 8);
      }
    }
  }
}

}  // namespace cliquevo::stereo
