// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/result.h"

namespace cliquevo::stereo {

enum class Prefilter { none, xsobel };

// Everything that steers the dense stereo stage. Defaults are the shipped ones.
struct StereoParams {
  Prefilter prefilter = Prefilter::xsobel;
  int prefilter_cap = 31;        // x-Sobel is clipped to +-cap grey levels, 1..63
  int window = 9;                // SAD window, px, odd, 5..21
  int min_disparity = -2;        // first disparity searched, px (a slightly wrong calibration puts far points below 0)
  int num_disparities = 128;     // number of disparities searched, multiple of 16, 16..256
  int uniqueness_percent = 10;   // the best cost must beat any other (not its neighbours) by this much, 0 = off
  int texture_threshold = 10;    // minimum mean of |pre-filtered gradient| per window, 0 = off
  int left_right_tolerance = 1;  // px, < 0 = off
  int speckle_size = 100;        // components smaller than this many px are removed, 0 = off
  int speckle_range = 1;         // px between neighbours of one component
  int workers = 1;               // threads over which rows are shared; the output does not depend on it

  Result<void> check() const;
};

}  // namespace cliquevo::stereo
