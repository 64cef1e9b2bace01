// SPDX-License-Identifier: BSD-3-Clause
// A calibration for the images at hand: made at another resolution it is scaled where aspect and principal point show
// that the whole image was, else refused.
#pragma once

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "drivers/calibration/calibration.h"

namespace cliquevo::drivers {

// Gives both cameras (and the prescribed pair) the size of the request's images; a note reports scaling.
Result<void> settle_size(StereoCalibration& calibration, const CalibrationRequest& request);

}  // namespace cliquevo::drivers
