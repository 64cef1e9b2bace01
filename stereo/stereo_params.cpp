// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/stereo_params.h"

#include <string>
#include <utility>

namespace cliquevo::stereo {

Result<void> StereoParams::check() const {
  struct Limit {
    const char* name;
    int value, lowest, highest;
  };
  const Limit limits[] = {
      {"prefilter_cap", prefilter_cap, 1, 63},
      {"window", window, 5, 21},
      {"window_height", window_height, 3, 21},
      {"min_disparity", min_disparity, -64, 64},
      {"num_disparities", num_disparities, 16, 256},
      {"uniqueness_percent", uniqueness_percent, 0, 100},
      {"texture_threshold", texture_threshold, 0, 63},
      {"left_right_tolerance", left_right_tolerance, -1, 64},
      {"speckle_size", speckle_size, 0, 1 << 20},
      {"speckle_range", speckle_range, 0, 64},
      {"smoothing", smoothing, 0, 3},
      {"workers", workers, 1, 64},
  };
  for (const Limit& l : limits) {
    if (l.value < l.lowest || l.value > l.highest) {
      return Error{std::string("stereo parameter out of range"), std::string(l.name) + " = " + std::to_string(l.value),
                   "give " + std::to_string(l.lowest) + " to " + std::to_string(l.highest)};
    }
  }
  for (const auto& [name, value] : {std::pair{"window", window}, {"window_height", window_height}}) {
    if (value % 2 == 0) {
      return Error{"stereo parameter out of range", std::string(name) + " = " + std::to_string(value),
                   "give an odd number"};
    }
  }
  if (num_disparities % 16 != 0) {
    return Error{"stereo parameter out of range", "num_disparities = " + std::to_string(num_disparities),
                 "give a multiple of 16"};
  }
  return {};
}

}  // namespace cliquevo::stereo
