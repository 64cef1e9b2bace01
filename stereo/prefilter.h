// SPDX-License-Identifier: BSD-3-Clause
// Pre-filter: takes brightness away and leaves horizontal structure, the only kind that tells disparities apart.
#pragma once

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"
#include "stereo/stereo_params.h"

namespace cliquevo::stereo {

// An image for the matcher: the view lies in storage with neutral margins left and right.
class MatchingImage {
 public:
  // Allocates, and fills the margins with the neutral value.
  void prepare(int width, int height, int neutral);
  std::uint8_t* row(int y) { return storage_.view().row(y) + kernels::kMargin; }
  const std::uint8_t* row(int y) const { return storage_.view().row(y) + kernels::kMargin; }
  std::ptrdiff_t stride() const { return storage_.view().stride; }

 private:
  Image<std::uint8_t> storage_;
};

// Rows [begin, end) of `image` -> the same rows of `filtered` (0 .. 2 * cap, the paper's J) and `matching` (0 .. 2 *
// range). Above the first and below the last row the image is continued by that row.
void prefilter_rows(const kernels::Table& kernel, const StereoParams& params, ImageView<const std::uint8_t> image,
                    int begin, int end, ImageView<std::uint8_t> filtered, MatchingImage& matching);

}  // namespace cliquevo::stereo
