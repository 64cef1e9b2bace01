// SPDX-License-Identifier: BSD-3-Clause
// What the readers of all calibration formats share: their input, and the checks that every result goes through.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

struct CalibrationRequest {
  std::string path;  // file or folder
  int width = 0;     // of the images, 0 = unknown
  int height = 0;
  int left_camera = 0;  // numbers of the eyes, where a file holds more cameras (KITTI's 0..3)
  int right_camera = 1;
};

Result<StereoCalibration> read_calibration(const CalibrationRequest& request);

// What was found wrong with the calibration named `where` (file, and key or line).
Error calibration_error(const std::string& what, const std::string& where);
// Sizes of the file and of the images differ.
Error size_error(const std::string& path, int width, int height, int image_width, int image_height);

// The last step of every reader: fills in missing sizes, checks sizes, cameras, rotations, baseline and the prescribed
// model; recognises a pair that needs no warping; sets `source`.
Result<StereoCalibration> finish_calibration(StereoCalibration calibration, const CalibrationRequest& request);

// Row-major numbers to a matrix.
Eigen::Matrix3d matrix3_from(const std::vector<double>& row_major);

}  // namespace cliquevo::drivers
