// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

void add_stereo_keys(stereo::RectifyParams& rectify, stereo::StereoParams& s, KeyTable& t) {
  t.section("rectify", "the pair that stereo and odometry work on; the warping costs the same whatever stands here");
  t.number(
      "scale", rectify.scale, "", between(0.05, 2),
      "its size as a share of the raw images'; auto = the daemon measures at its start what keeps the rate on this "
      "machine, 1 elsewhere");
  t.number("fov_deg", rectify.fov_deg, "deg", between(10, 150),
           "its horizontal field of view; auto = the calibration's own, else what the lenses fill, up to 120");

  t.section("stereo", "dense disparity");
  using stereo::Prefilter;
  t.choice("prefilter", s.prefilter,
           {{"none", Prefilter::none}, {"xsobel", Prefilter::xsobel}, {"gradients", Prefilter::gradients}},
           "compares gradients (horizontal and vertical in turn), xsobel (horizontal) or none (grey values)");
  t.number("prefilter_cap", s.prefilter_cap, "grey levels", between(1, 63), "x-Sobel gradients are clipped to this");
  t.number("window", s.window, "px", odd_between(5, 21), "width of the SAD window");
  t.number("window_height", s.window_height, "px", odd_between(3, 21),
           "its height: ground leans away, low windows follow it");
  t.number("min_disparity", s.min_disparity, "px", between(-64, 64),
           "first disparity searched; a calibration slightly off puts far points below 0");
  t.number("num_disparities", s.num_disparities, "px", multiple_between(16, 16, 256),
           "number searched; more sees nearer things and takes longer");
  t.number("uniqueness_percent", s.uniqueness_percent, "%", between(0, 100),
           "the best match must beat all others by this; 0 = off");
  t.number("texture_threshold", s.texture_threshold, "grey levels", between(0, 63),
           "least mean gradient in a window; 0 = off");
  t.number("left_right_tolerance", s.left_right_tolerance, "px", between(-1, 64),
           "largest difference between matching left to right and back; -1 = off");
  t.number("speckle_size", s.speckle_size, "px", between(0, 1 << 20),
           "smaller patches of disparity are removed; 0 = off");
  t.number("speckle_range", s.speckle_range, "px", between(0, 64), "difference between neighbours of one patch");
  t.number("smoothing", s.smoothing, "px", between(0, 3),
           "mean over neighbours this near and less than 1 px of disparity away; 0 = off");
  t.number("workers", s.workers, "", between(1, 64), "threads that share the rows; the result does not depend on it");
}

}  // namespace cliquevo::daemon
