// SPDX-License-Identifier: BSD-3-Clause
// Step A7: how well the motion is known. One named term per line; what is computed here is published.
#pragma once

#include <vector>

#include "core/vo/checks.h"
#include "core/vo/noise.h"
#include "core/vo/self_check.h"

namespace cliquevo::vo {

// Covariance of a judged motion [translation m, rotation vector rad], a left perturbation: the solution's own, times
// what noise, overlapping patches, small coverage, uneven light and an unsettled calibration add to it.
// `beside_key`: an older reference was in the solution. `scratch` is only working space.
Matrix6d uncertainty(const CheckInput& input, bool beside_key, const VoParams& params, const SelfCheck& check,
                     std::vector<float>& scratch);

// By which the published covariance is larger than that: what may be wrong with a motion that is known well by all that
// was seen. Beside the above, not in it: a first frame is no worse for it, only less certain, and refusing it leaves a
// longer gap to the next one, which would be less certain still. `running_ground`: the check's evidence.
double doubt_factor(const CheckInput& input, const CameraNoise& noise, const Evidence& running_ground);
// Beside a kept reference the current frame may be better known than it was known where the previous one is: the
// motion between them then takes back the previous frame's error, and its covariance has both. `before`: covariance of
// the previous frame's motion, as a perturbation of this one's.
Matrix6d with_error_taken_back(const Matrix6d& covariance, const Matrix6d& before);

// 0 (nothing is known) to 100 (known to a small part of what is enough): for those who integrate poses.
int quality(const Checks& checks);

}  // namespace cliquevo::vo
