// SPDX-License-Identifier: BSD-3-Clause
// Raw Bayer mosaics: whether images are one, and mosaics to grey.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"

namespace cliquevo::drivers {

enum class Bayer {
  automatic,  // a mosaic where the images show it beyond doubt
  none,
  rggb,
  bggr,
  grbg,
  gbrg,
};

// In a mosaic the four pixels of a 2x2 cell differ by colour, everywhere in the same way; in a grey image they differ
// by texture and noise alone.
class MosaicEvidence {
 public:
  void add(ImageView<const std::uint8_t> image);
  bool is_mosaic() const;
  // Where green is: true = upper left and lower right of a cell (GRBG, GBRG), false = the other two (RGGB, BGGR).
  bool green_first() const { return down_ < up_; }

 private:
  double down_ = 0.0;    // (upper left - lower right)^2, summed over blocks
  double up_ = 0.0;      // (upper right - lower left)^2
  double across_ = 0.0;  // (mean of the one diagonal - mean of the other)^2
  double light_ = 0.0;   // mean brightness
  std::int64_t blocks_ = 0;
};

// A mosaic to grey, in place: each pixel becomes the mean of its surroundings with weights 1 2 1 in both directions.
// That holds one part of red, two of green, one of blue at every pixel and of every pattern, and no trace of the cells.
class MosaicToGrey {
 public:
  void convert(ImageView<std::uint8_t> image);

 private:
  std::vector<std::uint16_t> rows_[3];  // sums along the row; three of them at a time
};

}  // namespace cliquevo::drivers
