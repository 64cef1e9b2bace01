// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/result.h"

namespace cliquevo::vo {

// Step A4's test on mutual distances.
enum class Consistency { fixed, range_aware };
// What the pose does on a failed frame.
enum class AfterFailure { hold, constant_velocity };
// Where step A2 looks for corners.
enum class CornerImage { filtered, intensity };

// Everything that steers the odometry. Defaults are the shipped ones: one set for every vehicle.
struct VoParams {
  // A2, features
  int max_features = 350;        // kept a frame, 50..1000
  int cell_px = 32;              // side of the cells over which features are spread, 16..256
  int corner_threshold = 20;     // FAST threshold to begin with, grey levels, 1..128; adapts to the picture
  int min_corner_threshold = 4;  // it never falls below this: weaker corners are noise
  CornerImage corner_image = CornerImage::intensity;  // where corners are looked for
  int descriptor_window = 7;  // side of the descriptor, px: 5, 7, 9 or 11 (7 x 7 less its centre = 48 bytes)

  // A4, clique
  Consistency consistency = Consistency::range_aware;
  double consistency_delta_m = 0.05;  // fixed: distances may differ by this much; range-aware: by this much at least
  double consistency_sigmas = 3.0;    // range-aware: and by so many standard deviations
  double match_sigma_px = 0.5;        // of a corner's position, unrefined
  double match_disparity_sigma_px = 0.5;  // of its disparity, unrefined

  // Sub-pixel refinement (beyond the paper; core/README.md has the reasons)
  bool refine = true;                  // find each feature of the reference again to a fraction of a pixel
  int refine_radius_px = 3;            // half side of the patch, 2..7
  int refine_iterations = 8;           // at most
  double min_patch_correlation = 0.8;  // of patches that are the same; less only where noise is all their difference
  double sigma_px = 0.3;               // of a refined position
  double disparity_sigma_px = 1.0;     // of a refined disparity: loose, so that a systematic error cannot set the scale
  bool use_key_frame = true;           // estimate against a kept reference as well as the previous frame
  double key_frame_overlap = 0.4;      // a new reference when less than this share of its features is found again
  // Correct disparities for the error of the calibration that ordinary driving shows (core/vo/self_check.h); it is
  // measured and reported in any case, with `refine`.
  bool compensate_calibration = true;

  // A5, motion
  int solver_iterations = 15;  // Levenberg-Marquardt, at most
  double huber_sigmas = 1.5;   // residuals beyond count linearly
  double trim_sigmas = 4.0;    // residuals beyond are dropped before the second solution

  // A6, validation
  int min_inliers = 10;                // 3 is the geometric minimum
  double min_eigenvalue_ratio = 0.02;  // spread of the inliers in the image, smaller / larger axis (variances)
  double max_error_ratio = 5.0;        // RMS over the inliers, as a multiple of what the camera's noise makes expected
  double rival_share = 0.35;           // ambiguous: another motion has this share of the clique's support
  double max_contradiction = 0.14;     // or more than this share of the picture moved otherwise
  double max_running_ground = 4.0;     // change of surfaces beyond what left and right differ, times their scatter
  double max_uncertainty = 0.1;        // standard deviation of a motion, as a share of it

  int min_mover_points = 6;  // matches that an object must have to count as a mover

  AfterFailure after_failure = AfterFailure::constant_velocity;  // what the pose does on a failed frame

  // Names what is out of range.
  Result<void> check() const;
};

}  // namespace cliquevo::vo
