// SPDX-License-Identifier: BSD-3-Clause
// Pre-filter: takes brightness away and leaves horizontal structure, the only kind that distinguishes disparities.
#pragma once

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"
#include "stereo/stereo_params.h"

namespace cliquevo::stereo {

// An image for the matcher: the view lies in storage with margins left and right.
class MatchingImage {
 public:
  // Allocates; margins are 0.
  void prepare(int width, int height);
  std::uint8_t* row(int y) { return storage_.view().row(y) + kernels::kMargin; }
  const std::uint8_t* row(int y) const { return storage_.view().row(y) + kernels::kMargin; }
  std::ptrdiff_t stride() const { return storage_.view().stride; }

 private:
  Image<std::uint8_t> storage_;
};

// The curve that the gradients of the matching images go through.
kernels::Curve matching_curve(const StereoParams& params);
kernels::Channels matching_channels(const StereoParams& params);

// The pre-filtered pair that the matcher compares.
struct MatchingPair {
  MatchingImage left;
  MatchingImage right[2];  // by channel
  void prepare(int width, int height);
};

// Rows [begin, end) of both images -> the same rows of `filtered` (0 .. 2 * cap, the paper's J) and of the matching
// images. Above the first and below the last row an image is continued by that row.
void prefilter_rows(const kernels::Table& kernel, const StereoParams& params, ImageView<const std::uint8_t> left,
                    ImageView<const std::uint8_t> right, int begin, int end, ImageView<std::uint8_t> filtered,
                    MatchingPair& matching);

}  // namespace cliquevo::stereo
