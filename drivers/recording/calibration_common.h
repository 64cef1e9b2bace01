// SPDX-License-Identifier: BSD-3-Clause
// What the readers of all calibration formats share: their input, and the checks that every result goes through.
#pragma once

#include <functional>
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

// A calibration may lie in two files: one an eye, or intrinsics and extrinsics.
enum class FilePair { eyes, parts };
struct NamedText {
  std::string path;
  std::string text;
};
using SecondFile = std::function<Result<NamedText>(FilePair)>;

// Any format, from memory; `second` is asked for the other file where there are two.
Result<StereoCalibration> parse_calibration(const std::string& text, const CalibrationRequest& request,
                                            const SecondFile& second);
// Whether a file is the right eye's by its name.
bool is_right_eye(const std::string& path);
// The file in a folder that serves as calibration, by the usual names; empty = none.
std::string find_calibration(const std::string& folder);

// What was found wrong with the calibration named `where` (file, and key or line).
Error calibration_error(const std::string& what, const std::string& where);
// Sizes of the file and of the images differ.
Error size_error(const std::string& path, int width, int height, int image_width, int image_height);

// The last step of every reader: fills in missing sizes, checks sizes, cameras, rotations, baseline and the prescribed
// model; recognises a pair that needs no warping; sets `source`.
Result<StereoCalibration> finish_calibration(StereoCalibration calibration, const CalibrationRequest& request);

// A rotation to the digits that files print; the error names `where`.
Result<void> check_rotation(const Eigen::Matrix3d& R, const std::string& where);

// Distortion by its name in EuRoC, Kalibr, ROS or OpenCV files and its coefficients; empty name: by their number.
Result<void> set_distortion(const std::string& name, const std::vector<double>& coefficients, const std::string& where,
                            CameraCalibration& camera);

// Focal lengths and principal point of a row-major 3x3 matrix that must be one of a pinhole camera without skew.
Result<void> set_camera_matrix(const std::vector<double>& K, const std::string& where, CameraCalibration& camera);

// Pinhole projections (row-major 3x4) of the two rectified eyes to the model; width and height are left at 0.
Result<StereoModel> model_from_projections(const std::vector<double>& P_left, const std::vector<double>& P_right,
                                           const std::string& where);

// Row-major numbers to a matrix.
Eigen::Matrix3d matrix3_from(const std::vector<double>& row_major);

}  // namespace cliquevo::drivers
