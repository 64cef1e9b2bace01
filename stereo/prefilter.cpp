// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/prefilter.h"

#include <algorithm>

namespace cliquevo::stereo {

void MatchingImage::prepare(int width, int height, int neutral) {
  storage_.resize(width + 2 * kernels::kMargin, height);
  storage_.fill(static_cast<std::uint8_t>(neutral));
}

void prefilter_rows(const kernels::Table& kernel, const StereoParams& params, ImageView<const std::uint8_t> image,
                    int begin, int end, ImageView<std::uint8_t> filtered, MatchingImage& matching) {
  const int cap = params.prefilter_cap;
  const int range = kernels::matching_range(params.window, cap);
  const int scale = std::min(32767, (range * 32768 + cap / 2) / cap);
  for (int y = begin; y < end; ++y) {
    const std::uint8_t* row = image.row(y);
    std::uint8_t* out = filtered.row(y);
    std::uint8_t* match = matching.row(y);
    if (params.prefilter == Prefilter::xsobel) {
      kernel.prefilter_row(image.row(std::max(y - 1, 0)), row, image.row(std::min(y + 1, image.height - 1)),
                           image.width, cap, scale, range, out, match);
    } else {
      for (int x = 0; x < image.width; ++x) {
        out[x] = row[x];
        match[x] = static_cast<std::uint8_t>(row[x] * (2 * range + 1) >> 8);
      }
    }
  }
}

}  // namespace cliquevo::stereo
