// SPDX-License-Identifier: BSD-3-Clause
// Samples of 10 and 12 bits that share bytes, as cameras send them, to 8 bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/image.h"

namespace cliquevo::drivers {

enum class PackedSamples {
  mipi_10,        // four bytes with the upper bits, one with the lower (Y10P, pRAA, ...)
  mipi_12,        // two bytes with the upper bits, one with the lower (Y12P, pRCC, ...)
  big_endian_10,  // bit after bit, highest first (Y10B)
  gige_10_or_12,  // upper bits, lower bits of both, upper bits (Mono10Packed, Mono12Packed)
  pfnc_10,        // bit after bit, lowest first (Mono10p)
  pfnc_12,        // likewise (Mono12p)
};

// The upper 8 bits of each sample. `stride`: bytes from row to row, 0 = the samples run on without a gap. false: the
// data is too short.
bool unpack_samples(PackedSamples kind, const std::uint8_t* data, std::size_t size, std::size_t stride,
                    ImageView<std::uint8_t> out);

}  // namespace cliquevo::drivers
