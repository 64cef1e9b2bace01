// SPDX-License-Identifier: BSD-3-Clause
// What this camera's noise was measured to be, learned over its frames. Weights, gates, checks and the covariance are
// in these units, so that one set of parameters serves a clean camera and a rough one.
#pragma once

#include "core/vo/frame.h"
#include "core/vo/motion.h"

namespace cliquevo::vo {

class CameraNoise {
 public:
  // Patch alignment errs by this much on perfect images too (interpolation, the surface's curvature), px; measured on
  // the simulator and on recordings as what is left of the reprojection error where rows do not scatter.
  static constexpr double kAlignmentError_px = 0.13;

  CameraNoise() { reset(); }
  void reset();

  // One frame's left/right measurements (Frame::row_scatter_px, row_shift_px). Before its motion is judged.
  void add_views(const Frame& frame);
  // One valid frame's motion.
  void add_motion(const Motion& motion);

  // RMS reprojection error of a right motion, px: what patches scatter between the left and the right image of one
  // moment, and what alignment errs by itself.
  double expected_error_px() const;
  // Width of the error common to all disparities of a frame (a rig that flexes or shakes); near 0 for a stiff one, px.
  double shift_sigma_px() const;
  // The same for one frame's motion: wider where the frame's own reading lies far outside.
  double shift_sigma_px(const Motion& first) const;
  // How far the frame's own reading of it lies outside what is known of the camera, in variances.
  double shift_news(const Motion& motion) const;
  // By how much a motion's variance grows while little is known of this camera; 1 in the end.
  double unsettled() const;
  // Rows by which this frame's right image is lower than the calibration has it, as far as that exceeds noise.
  double row_shift_px(const Frame& frame) const;
  // RMS difference of grey levels between corresponding patches of one moment, after gain and bias.
  double grey_levels() const { return grey_levels_; }

 private:
  double row_scatter_px_ = 0.0;
  double row_shift_variance_ = 0.0;  // px^2
  double grey_levels_ = 0.0;
  double views_ = 0.0;           // frames that count
  double shift_variance_ = 0.0;  // px^2, less the part that noise explains
  double motions_ = 0.0;         // what they weigh
  int valid_ = 0;                // how many they were
};

}  // namespace cliquevo::vo
