// SPDX-License-Identifier: BSD-3-Clause
// Samples of more than 8 bits to 8 bits: by how much, as a whole recording's images show it.
#pragma once

#include <cstdint>

#include "core/base/image.h"
#include "drivers/images/grey_picture.h"

namespace cliquevo::drivers {

// Which bits of 16 are in use. Sensors of 10, 12 or 14 bits leave the upper ones empty, or the lower.
class SampleDepth {
 public:
  void add(const GreyPicture& picture);
  bool deep() const { return deep_; }  // any of the images had more than 8 bits
  // Bits to shift samples down by: 0 to 8.
  int shift() const;

 private:
  bool deep_ = false;
  unsigned used_ = 0;  // every bit that was set anywhere
  int named_ = 0;
};

// Shifts every sample; what is brighter than 8 bits hold stays white.
void shift_to_bytes(ImageView<const std::uint16_t> words, int shift, Image<std::uint8_t>& bytes);

}  // namespace cliquevo::drivers
