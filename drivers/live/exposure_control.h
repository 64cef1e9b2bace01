// SPDX-License-Identifier: BSD-3-Clause
// An exposure control with a limit, for cameras whose own knows none. What blurs a picture is the exposure time: it
// goes up to the limit first, then the gain, and down in the opposite order.
//
// After Shim, Lee and Kweon, "Auto-adjusting camera exposure for outdoor robotics using gradient information" (IROS
// 2014): of the picture brightened and darkened by several gammas, the one with most gradients shows which way to go.
#pragma once

#include <cstdint>

#include "core/base/image.h"

namespace cliquevo::drivers {

struct ExposureSetting {
  double exposure_us = 0.0;
  double gain = 0.0;  // in the camera's unit
  bool operator==(const ExposureSetting&) const = default;
};

struct ExposureRange {
  ExposureSetting least;
  ExposureSetting most;  // most.exposure_us: the smaller of the camera's and the user's limit
};

// The gamma in 1/1.9 to 1.9 that shows most gradients: below 1 the picture is too dark, above 1 too bright. A picture
// without any gradients gives an end of that range, or 1 where its brightness is in the middle.
double best_gamma(ImageView<const std::uint8_t> image);

// What to set next, from a picture that was taken with `now`. A camera has shown what was set after two or three
// frames: call it four times a second. The same setting again: leave it.
ExposureSetting next_exposure(ImageView<const std::uint8_t> image, const ExposureSetting& now,
                              const ExposureRange& range);

}  // namespace cliquevo::drivers
