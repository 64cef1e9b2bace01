// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/sample_depth.h"

#include <algorithm>
#include <bit>

namespace cliquevo::drivers {

namespace {

constexpr int kBytesBits = 8;
constexpr int kWordBits = 16;
// Values this large whose lowest bits are never set fill their word from the top.
constexpr int kLeftAlignedFrom = 13;
constexpr int kLeftAlignedZeros = 2;

}  // namespace

void SampleDepth::add(const GreyPicture& picture) {
  if (!picture.deep) return;
  deep_ = true;
  named_ = std::max(named_, picture.bits_in_use);
  const ImageView<const std::uint16_t> words = picture.words.cview();
  for (int y = 0; y < words.height; ++y) {
    const std::uint16_t* row = words.row(y);
    unsigned used = 0;
    for (int x = 0; x < words.width; ++x) used |= row[x];
    used_ |= used;
  }
}

int SampleDepth::shift() const {
  if (named_ > 0) return std::max(0, named_ - kBytesBits);
  if (used_ == 0) return kWordBits - kBytesBits;  // nothing but black: as if all bits were in use
  const int top = std::bit_width(used_);
  if (top <= kBytesBits) return 0;
  if (top >= kLeftAlignedFrom && std::countr_zero(used_) >= kLeftAlignedZeros) return kWordBits - kBytesBits;
  return (top + 1) / 2 * 2 - kBytesBits;  // sensors have 10, 12, 14 or 16 bits: a dark picture leaves the top one empty
}

void shift_to_bytes(ImageView<const std::uint16_t> words, int shift, Image<std::uint8_t>& bytes) {
  bytes.resize(words.width, words.height);
  for (int y = 0; y < words.height; ++y) {
    const std::uint16_t* from = words.row(y);
    std::uint8_t* to = bytes.view().row(y);
    for (int x = 0; x < words.width; ++x) {
      to[x] = static_cast<std::uint8_t>(std::min(static_cast<unsigned>(from[x]) >> static_cast<unsigned>(shift), 255U));
    }
  }
}

}  // namespace cliquevo::drivers
