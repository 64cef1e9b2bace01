// SPDX-License-Identifier: BSD-3-Clause
// What the readers of all calibration formats share: the checks that every result goes through, and errors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "drivers/calibration/calibration.h"
#include "drivers/calibration/document.h"

namespace cliquevo::drivers {

// What was found wrong with the calibration named `where` (file, and key or line).
Error calibration_error(const std::string& what, const std::string& where);
// Sizes of the file and of the images differ.
Error size_error(const std::string& path, int width, int height, int image_width, int image_height);

// The last step of every reader: unit and size, checks of cameras, lenses, rotations, baseline and the prescribed
// model; recognises a pair that needs no warping; sets `source`. Sizes left at 0 become the images'. `format_unit_m`:
// metres a unit of the file's lengths (the calibration is in metres already).
Result<StereoCalibration> finish_calibration(StereoCalibration calibration, const CalibrationRequest& request,
                                             double format_unit_m = 1.0);

// Said where the file's first camera lies on the right, and is taken for the right one.
inline constexpr char kExchangedNote[] =
    "the calibration's first camera lies right of its second one: it is taken for the right camera";
// Exchanges the cameras where the right one lies left of the left one, with a note: for formats whose poses cannot be
// meant otherwise.
void order_cameras(StereoCalibration& calibration);

// A rotation to the digits that files print; the error names `where`.
Result<void> check_rotation(const Eigen::Matrix3d& R, const std::string& where);
bool is_rotation(const Eigen::Matrix3d& R);
// The lens must bend less than it projects over most of the image.
Result<void> check_lens(const CameraCalibration& camera, const std::string& where);
Result<void> check_model(const StereoModel& model, const std::string& where);

// Model and distortion by their names in all formats ("pinhole" and "radtan", "ds", "omni-radtan") and the
// coefficients; empty names: by their number.
Result<void> set_distortion(const std::string& name, const std::vector<double>& coefficients, const std::string& where,
                            CameraCalibration& camera);

// Whether it is the name of a lens model that set_distortion() takes.
bool is_lens_name(const std::string& name);

// Focal lengths and principal point of a row-major 3x3 matrix that must be one of a pinhole camera without skew.
Result<void> set_camera_matrix(const std::vector<double>& K, const std::string& where, CameraCalibration& camera);

// The size that the file names; a camera of a file that names none keeps its own.
Result<void> set_image_size(const Document& file, CameraCalibration& camera);

// Pinhole projections (row-major 3x4) of the two rectified cameras to the model; width and height are left at 0.
Result<StereoModel> model_from_projections(const std::vector<double>& P_left, const std::vector<double>& P_right,
                                           const std::string& where);

// Row-major numbers to a matrix.
Eigen::Matrix3d matrix3_from(const std::vector<double>& row_major);

// Numbers of a line in a text file, none of them absurdly large.
Result<std::vector<double>> calibration_numbers(std::string_view text, const std::string& where);

}  // namespace cliquevo::drivers
