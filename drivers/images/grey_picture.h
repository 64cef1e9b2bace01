// SPDX-License-Identifier: BSD-3-Clause
// One image as its file holds it, in grey; and what every decoder shares.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/base/image.h"

namespace cliquevo::drivers {

using Bytes = std::span<const std::uint8_t>;

struct GreyPicture {
  Image<std::uint8_t> bytes;   // samples of up to 8 bits, spread over 0 to 255
  Image<std::uint16_t> words;  // samples of more, as stored
  bool deep = false;           // the samples are in `words`
  int bits_in_use = 0;         // bits of a word that are in use, where the file has it; 0 = it does not
  int warnings = 0;            // what the decoder warned of although every pixel is there

  int width() const { return deep ? words.width() : bytes.width(); }
  int height() const { return deep ? words.height() : bytes.height(); }
};

inline constexpr int kMostSidePx = 16384;
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 26U;  // 67 million: none of them decoded beyond

// Why an image of this size is refused; empty = it is accepted. Decoders call it before they allocate or decode.
std::string refuse_size(std::int64_t width, std::int64_t height);

// Colour to grey by the BT.601 weights, as libpng computes it: 15 bits, cut; equal samples stay as they are.
inline unsigned grey_of_rgb(unsigned red, unsigned green, unsigned blue) {
  return red == green && red == blue ? red : (9797U * red + 19234U * green + 3737U * blue) >> 15U;
}

}  // namespace cliquevo::drivers
