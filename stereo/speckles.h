// SPDX-License-Identifier: BSD-3-Clause
// Speckles: small islands of disparity that differ from all around them are mismatches more often than not.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"

namespace cliquevo::stereo {

class SpeckleFilter {
 public:
  // Memory for the worst image of this size.
  void prepare(int width, int height);
  // Components of known pixels, 4-connected over steps of at most `range` (in the image's unit), smaller than
  // `size` pixels become unknown.
  void remove(ImageView<std::int16_t> disparity, int size, int range);

 private:
  struct Run {
    std::int32_t begin, end;  // columns
    std::int32_t y;
    std::int32_t parent;
    std::int32_t pixels;
  };
  std::int32_t root(std::int32_t i);
  void join(std::int32_t a, std::int32_t b);

  std::vector<Run> runs_;
};

}  // namespace cliquevo::stereo
