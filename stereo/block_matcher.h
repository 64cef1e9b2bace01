// SPDX-License-Identifier: BSD-3-Clause
// From the matcher's costs to trusted sub-pixel disparities: one row at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"
#include "stereo/prefilter.h"
#include "stereo/stereo_params.h"

namespace cliquevo::stereo {

// Matches rows one after the other, downwards or upwards; each worker owns one.
class StripMatcher {
 public:
  void prepare(const StereoParams& params, int width);
  // Row y of the disparity image; unless it is the worker's first, row y - step came before. `filtered` is the
  // pre-filtered left image, which the texture test reads.
  void match(const kernels::Table& kernel, const StereoParams& params, const MatchingPair& pair,
             ImageView<const std::uint8_t> filtered, int y, int step, bool first, ImageView<std::int16_t> disparity);

 private:
  void sum_texture(const kernels::Table& kernel, const StereoParams& params, int y, int step,
                   ImageView<const std::uint8_t> filtered, bool first);

  Image<std::uint8_t> columns_;
  Image<std::uint16_t> costs_;
  Image<std::uint16_t> found_;
  std::vector<std::uint8_t> neutral_;  // a row without texture
  std::vector<std::uint16_t> texture_columns_, texture_;
  std::vector<std::uint32_t> right_best_;  // see kernels::CrossCheck
  std::vector<std::int16_t> astray_;
};

}  // namespace cliquevo::stereo
