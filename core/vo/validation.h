// SPDX-License-Identifier: BSD-3-Clause
// Step A6: is this motion to be trusted?
#pragma once

#include <vector>

#include "core/vo/motion.h"
#include "core/vo/visual_odometry.h"

namespace cliquevo::vo {

// Spread of the inliers in the current image: smaller over larger eigenvalue of the covariance of their positions.
// 0: on a line; 1: round. 0 for fewer than three.
double spread_ratio(const std::vector<Observation>& observations);

// By how much the inliers' patches changed since the (first) reference more than between the two eyes of one moment, as
// a share of the latter; medians. Rigid surfaces look from place to place as they do from eye to eye; ground whose
// texture runs (water, blown sand), where a motion can be consistent and yet wrong, does not, and its points scatter
// about the motion besides: the product with the reprojection error tells it. `scratch` is only working space.
double excess_change(const std::vector<Observation>& observations, std::vector<float>& scratch);

// Ground that runs, seen near and far at once, does not fit one motion with the disparities as they are known: the
// residuals ask for an error common to all of them, which should be known by now. 1 (no news) to 3.
double surprise(const Motion& motion);

// How unevenly the light on the inliers changed since the (first) reference, grey levels: nine in ten changed by no
// more than that besides what all of them did. A glow that comes or goes draws every feature along its slope.
double change_of_light(const std::vector<Observation>& observations, std::vector<float>& scratch);

// How far the inliers' disparities in the current frame are from where the motion puts them, px, RMS.
double disparity_error_px(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                          const RigidTransform& T_prev_cur, const StereoModel& model);

// disparity_error_px: see above; 0 where disparities are not refined.
Status validate(const Motion& motion, double eigenvalue_ratio, double disparity_error_px, const VoParams& params);

}  // namespace cliquevo::vo
