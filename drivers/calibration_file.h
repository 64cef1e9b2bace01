// SPDX-License-Identifier: BSD-3-Clause
// Reads stereo calibrations: KITTI (calib.txt, calib_cam_to_cam.txt), EuRoC sensor.yaml pairs, Kalibr camchain, ROS
// camera_info pairs, OpenCV stereo YAML, DSO stereo files.
#pragma once

#include <string>

#include "core/base/camera_model.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

// path: a file, or a folder that holds the files of both eyes. width, height: of the images it is for (0 = unknown;
// some formats do not tell); a calibration of another size is an error.
Result<StereoCalibration> read_calibration(const std::string& path, int width, int height);

}  // namespace cliquevo::drivers
