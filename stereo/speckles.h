// SPDX-License-Identifier: BSD-3-Clause
// Speckles: small islands of disparity that differ from all around them are mismatches more often than not.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo {

class SpeckleFilter {
 public:
  // Memory for the worst image of this size.
  void prepare(int width, int height);
  // Components of known pixels, 4-connected over steps of at most `range` (in the image's unit), smaller than
  // `size` pixels become unknown.
  void remove(const kernels::Table& kernel, ImageView<std::int16_t> disparity, int size, int range);

 private:
  struct Run {
    std::int32_t begin, end;  // columns
    std::int32_t y;
    std::int32_t parent;  // of equal component, further up
    std::int32_t pixels;
  };
  // Bits of the pixels of a row; see kernels::LinkRow.
  struct Bits {
    std::vector<std::uint64_t> known, across, down;
  };
  std::int32_t find_runs(const Bits& bits, int y, std::int32_t count);
  void join_rows(const Bits& row, const Bits& above, std::int32_t a, std::int32_t b);
  std::int32_t root(std::int32_t i);
  void join(std::int32_t a, std::int32_t b);

  std::vector<Run> runs_;
  Bits bits_[2];  // of two rows, taking turns
  std::vector<std::int16_t> unknown_;
};

}  // namespace cliquevo::stereo
