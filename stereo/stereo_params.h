// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/result.h"

namespace cliquevo::stereo {

// What is compared between left and right. none: grey values. xsobel: the horizontal gradient, clipped. gradients:
// horizontal and vertical gradients alternating like the squares of a chessboard, through a curve that keeps weak ones.
enum class Prefilter { none, xsobel, gradients };

// Everything that steers the dense stereo stage. Defaults are the shipped ones, chosen in stereo/README.md.
struct StereoParams {
  Prefilter prefilter = Prefilter::gradients;  // of what is compared
  int prefilter_cap = 31;        // x-Sobel is clipped to +-cap grey levels, 1..63: in J always, in matching with xsobel
  int window = 13;               // width of the SAD window, px, odd, 5..21
  int window_height = 7;         // its height, px, odd, 5..21: ground leans away, low windows follow it
  int min_disparity = -2;        // first disparity searched, px (a slightly wrong calibration puts far points below 0)
  int num_disparities = 128;     // number of disparities searched, multiple of 16, 16..256
  int uniqueness_percent = 10;   // the best cost must beat any other (not its neighbours) by this much, 0 = off
  int texture_threshold = 2;     // least mean of the clipped |x-Sobel| over the window, grey levels, 0 = off
  int left_right_tolerance = 1;  // px, < 0 = off
  int speckle_size = 100;        // components smaller than this many px are removed, 0 = off
  int speckle_range = 1;         // px between neighbours of one component
  int smoothing = 2;             // px to each side, 0..3: mean over known neighbours less than 1 px apart, 0 = off
  int workers = 1;               // threads over which rows are shared; the output does not depend on it

  // Names what is out of range.
  Result<void> check() const;
};

}  // namespace cliquevo::stereo
