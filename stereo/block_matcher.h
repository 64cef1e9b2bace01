// SPDX-License-Identifier: BSD-3-Clause
// From the matcher's costs to trusted sub-pixel disparities: one row at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"
#include "stereo/stereo_params.h"

namespace cliquevo::stereo {

// Matches the rows of one strip from top to bottom; each worker owns one.
class StripMatcher {
 public:
  void prepare(const StereoParams& params, int width);
  // Rows [begin, end) of the disparity image. left, right: pixel (0, 0) of the matching images; filtered: the
  // pre-filtered left image, which the texture test reads.
  void match(const kernels::Table& kernel, const StereoParams& params, const std::uint8_t* left,
             const std::uint8_t* right, std::ptrdiff_t stride, ImageView<const std::uint8_t> filtered, int begin,
             int end, ImageView<std::int16_t> disparity);

 private:
  void finish_row(const StereoParams& params, int y, ImageView<const std::uint8_t> filtered, bool first,
                  std::int16_t* out);
  void sum_texture(const StereoParams& params, int y, ImageView<const std::uint8_t> filtered, bool first);

  Image<std::uint8_t> columns_;
  Image<std::uint16_t> costs_;
  std::vector<std::int16_t> found_;
  std::vector<std::uint16_t> best_, below_, above_, second_;
  std::vector<int> texture_columns_, texture_;
  std::vector<std::uint32_t> right_best_;  // cost and left column of each right pixel's best partner
};

}  // namespace cliquevo::stereo
