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

Status validate(const Motion& motion, double eigenvalue_ratio, const VoParams& params);

}  // namespace cliquevo::vo
