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

// By how much the inliers' patches changed since the (first) reference more than between the two eyes of one moment,
// as a difference of correlations; medians. Rigid surfaces look from place to place as they do from eye to eye; ground
// whose texture runs (water, blown sand), where a motion can be consistent and yet wrong, does not, and its points
// scatter about the motion besides: the product with the reprojection error tells it. `scratch` is only working space.
double excess_change(const std::vector<Observation>& observations, std::vector<float>& scratch);

Status validate(const Motion& motion, double eigenvalue_ratio, const VoParams& params);

}  // namespace cliquevo::vo
