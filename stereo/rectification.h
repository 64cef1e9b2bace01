// SPDX-License-Identifier: BSD-3-Clause
// Which way both cameras are turned, and the pinhole pair they become.
#pragma once

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "stereo/rectify_params.h"

namespace cliquevo::stereo {

// The prescribed rectification where the calibration has one, checked; otherwise one of our own. Both are turned
// by half of the rotation between them and then together until the baseline is the X axis (Bouguet's way; Fusiello et
// al. 2000 for the construction). The pinhole pair has the left image's size, equal principal points and, as far as the
// pixels' size allows (3/4 to 3/2 of the raw one), the shortest focal length that leaves no border without a source and
// no wider view than RectifyParams::kMostFovDeg. Then field of view and scale as the params have them.
Result<PrescribedRectification> choose_rectification(const StereoCalibration& calibration,
                                                     const RectifyParams& params = {});

}  // namespace cliquevo::stereo
