// SPDX-License-Identifier: BSD-3-Clause
// KITTI's calibration files. Source: the development kits of KITTI odometry and KITTI raw data.
#pragma once

#include <string_view>

#include "drivers/recording/calibration_common.h"

namespace cliquevo::drivers {

// calib.txt of the odometry sequences: "P0: 12 numbers" a camera, projection of the rectified cameras.
Result<StereoCalibration> parse_kitti_odometry(std::string_view text, const CalibrationRequest& request);
// calib_cam_to_cam.txt of the raw drives: S, K, D, R, T as grabbed; S_rect, R_rect, P_rect rectified. The size of the
// images tells which of the two they are.
Result<StereoCalibration> parse_kitti_raw(std::string_view text, const CalibrationRequest& request);

}  // namespace cliquevo::drivers
