// SPDX-License-Identifier: BSD-3-Clause
// The lines that a replay or the daemon prints at its start: what the camera can see and how well it can measure.
#pragma once

#include <string>

#include "core/base/camera_model.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

inline constexpr double kDefaultSigmaDisparity_px = 0.25;

// Two lines without a final newline: baseline, focal length and field of view of the rectified pair; then the standard
// deviation of the depth at 5, 10 and 20 m for a disparity error of sigma_disparity_px.
std::string describe_geometry(const StereoModel& rectified, double sigma_disparity_px = kDefaultSigmaDisparity_px);
// One line without newline: what is played, size, number of pairs, rate, where the calibration is from, masks.
std::string describe_source(const SourceInfo& info);

}  // namespace cliquevo::drivers
