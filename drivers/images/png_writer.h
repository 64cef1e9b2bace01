// SPDX-License-Identifier: BSD-3-Clause
// Images to PNG files in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

// Quickly and hardly larger: camera images are noisy, more effort gains nothing.
Result<std::vector<unsigned char>> encode_png(ImageView<const std::uint8_t> grey);
Result<std::vector<unsigned char>> encode_png(ImageView<const std::uint16_t> grey);
// Three bytes a pixel, red first; the view counts bytes: it is three times as wide as the picture.
Result<std::vector<unsigned char>> encode_png_rgb(ImageView<const std::uint8_t> rgb);

}  // namespace cliquevo::drivers
