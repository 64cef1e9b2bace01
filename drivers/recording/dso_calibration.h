// SPDX-License-Identifier: BSD-3-Clause
// Stereo calibrations as DSO and its stereo variants read them:
//   Pinhole|RadTan|EquiDistant fx fy cx cy [distortion]     absolute (px), or relative to the size when cx and cy < 1
//   width height                                            of the images
//   crop | full | none | fx fy cx cy 0                      the output camera
//   width height                                            of the output
//   baseline                                                m
// Both eyes share the camera and lie in parallel, as DSO has it.
#pragma once

#include <string_view>

#include "drivers/recording/calibration_common.h"

namespace cliquevo::drivers {

Result<StereoCalibration> parse_dso(std::string_view text, const CalibrationRequest& request);

}  // namespace cliquevo::drivers
