// SPDX-License-Identifier: BSD-3-Clause
// How sharp a picture is beside another one, so that a change of blur is not taken for a change of what is seen.
#pragma once

#include <array>
#include <vector>

#include "core/base/image.h"
#include "core/vo/features.h"
#include "core/vo/matches.h"

namespace cliquevo::vo {

struct Frame;

// Logarithms, beside the first frame of all: of the variance within patches, and of their squared gradients along x, y
// and the two diagonals, less the mean of the four.
struct Sharpness {
  double contrast = 0.0;
  std::array<double, 4> along{};
};

// Variance of the grey levels between large parts of a picture, which blur leaves alone and exposure changes.
double contrast_of_parts(ImageView<const std::uint8_t> image);

// Sharpness of `current`: the reference's, and the medians over their matches, which were chosen in both pictures
// alike, of how the above changed; beside the variance of the whole picture (which exposure changes too). Changes that
// chance explains are none.
Sharpness sharpness_of(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
                       std::vector<float>& scratch);

// 1 - correlation that patches have with themselves in a picture of another sharpness: blur takes the part H of a patch
// L + H away, which leaves a correlation of |L| / |L + H|. Pictures blurred in different directions each lack a part of
// the other.
double change_by_blur(const Sharpness& a, const Sharpness& b);

}  // namespace cliquevo::vo
