// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

using vo::VoParams;

void add_features(VoParams& o, KeyTable& t) {
  t.group("Features");
  t.number("max_features", o.max_features, "", between(50, 1000), "kept a frame");
  t.number("cell_px", o.cell_px, "px", between(16, 256), "features are spread over cells of this side");
  t.number("corner_threshold", o.corner_threshold, "grey levels", between(1, 128),
           "FAST threshold to begin with, adapts to the picture; not below min_corner_threshold");
  t.number("min_corner_threshold", o.min_corner_threshold, "grey levels", between(1, 128), "it never falls below this");
  t.choice("corner_image", o.corner_image,
           {{"filtered", vo::CornerImage::filtered}, {"intensity", vo::CornerImage::intensity}},
           "where corners are detected: intensity, or the pre-filtered image");
  t.number("descriptor_window", o.descriptor_window, "px", odd_between(5, 11), "side of the descriptor");
}

void add_clique(VoParams& o, KeyTable& t) {
  t.group("Clique: which matches keep their distances in space");
  t.choice("consistency", o.consistency,
           {{"fixed", vo::Consistency::fixed}, {"range_aware", vo::Consistency::range_aware}},
           "fixed = distances agree within delta; range_aware = within the error of stereo at that range");
  t.number("consistency_delta_m", o.consistency_delta_m, "m", between(0, 10),
           "fixed: that delta; range_aware: allowed at least");
  t.number("consistency_sigmas", o.consistency_sigmas, "", between(0.5, 20),
           "range_aware: allowed standard deviations");
  t.number("match_sigma_px", o.match_sigma_px, "px", between(0.01, 10),
           "standard deviation of a corner's position before refinement");
  t.number("match_disparity_sigma_px", o.match_disparity_sigma_px, "px", between(0.01, 10), "and of its disparity");
}

void add_refinement(VoParams& o, KeyTable& t) {
  t.group("Sub-pixel refinement");
  t.flag("refine", o.refine, "find each feature of the reference again to a fraction of a pixel");
  t.number("refine_radius_px", o.refine_radius_px, "px", between(2, 7), "half side of the patch compared");
  t.number("refine_iterations", o.refine_iterations, "", between(1, 50), "at most");
  t.number("min_patch_correlation", o.min_patch_correlation, "", between(0.3, 1),
           "of two patches that are the same; less only where noise is all their difference");
  t.number("sigma_px", o.sigma_px, "px", between(0.01, 10), "standard deviation of a refined position");
  t.number("disparity_sigma_px", o.disparity_sigma_px, "px", between(0.01, 10),
           "of a refined disparity; loose, so that a systematic error cannot set the scale");
  t.flag("use_key_frame", o.use_key_frame, "estimate against a kept reference as well as the previous frame");
  t.number("key_frame_overlap", o.key_frame_overlap, "", between(0.05, 1),
           "take a new reference when less than this share of its features is found");
  t.flag("compensate_calibration", o.compensate_calibration,
         "correct disparities for the error of the calibration that driving itself shows");
}

void add_motion(VoParams& o, KeyTable& t) {
  t.group("Motion");
  t.number("solver_iterations", o.solver_iterations, "", between(1, 100), "Levenberg-Marquardt, at most");
  t.number("huber_sigmas", o.huber_sigmas, "", between(0.1, 100),
           "residuals beyond so many standard deviations count linearly");
  t.number("trim_sigmas", o.trim_sigmas, "", between(1, 100),
           "matches beyond so many are dropped before the second solution");
}

void add_validation(VoParams& o, KeyTable& t) {
  t.group("Validation: when a frame is called valid");
  t.number("min_inliers", o.min_inliers, "", between(3, 500), "features that the motion rests on, at least");
  t.number("min_eigenvalue_ratio", o.min_eigenvalue_ratio, "", between(0, 1),
           "their spread in the image, smaller to larger axis (variances)");
  t.number("max_error_ratio", o.max_error_ratio, "", between(0.1, 100),
           "root mean square over them, as a multiple of what the camera's noise makes expected");
  t.number("rival_share", o.rival_share, "", between(0.1, 1),
           "ambiguous when another motion has this share of the support of the first");
  t.number("max_contradiction", o.max_contradiction, "", between(0.01, 1),
           "or when more than this share of the picture moved otherwise");
  t.number("max_running_ground", o.max_running_ground, "", between(0.1, 1000),
           "or when surfaces change and their points scatter, as water does, by such a product");
  t.number("max_uncertainty", o.max_uncertainty, "", between(0.001, 100),
           "weakly known when a motion's standard deviation is a larger share of it");
  t.number("min_mover_points", o.min_mover_points, "", between(4, 500),
           "matches that a thing must have to count as a mover");
  t.choice("after_failure", o.after_failure,
           {{"hold", vo::AfterFailure::hold}, {"constant_velocity", vo::AfterFailure::constant_velocity}},
           "what the pose does on a failed frame");
}

}  // namespace

void add_odometry_keys(VoParams& o, KeyTable& t) {
  t.section("odometry", "from disparity to pose and status");
  add_features(o, t);
  add_clique(o, t);
  add_refinement(o, t);
  add_motion(o, t);
  add_validation(o, t);
}

}  // namespace cliquevo::daemon
