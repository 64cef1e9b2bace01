// SPDX-License-Identifier: BSD-3-Clause
// The vectorised inner loops of the odometry: one table an instruction set, all bit-identical to the reference.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/isa.h"

namespace cliquevo::vo {

// Bytes from one descriptor to the next; unused bytes are 0.
inline constexpr int kDescriptorStride = 128;

struct Kernels {
  // FAST-9 corners of one row: pixels x0 <= x < x1 of `row` (3 px of image on every side) with 9 contiguous pixels of
  // the 16 on the circle all brighter than centre + threshold or all darker than centre - threshold. Writes columns in
  // rising order and scores (the largest threshold that would still hold, <= 255); returns their number.
  int (*fast_row)(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::int16_t* columns,
                  std::uint8_t* scores);
  // Step A2': sums of absolute differences between one descriptor and `count` others, kDescriptorStride bytes apart;
  // `length` bytes each, rounded up to a multiple of 32 (the rest is 0).
  void (*sad_row)(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length,
                  std::uint16_t* scores);
};

// The table of the instruction set in force (core/base/isa.h).
const Kernels& kernels();
// A given one's, for tests and benches; nullptr when this build or machine lacks it.
const Kernels* kernels_for(Isa isa);

}  // namespace cliquevo::vo
