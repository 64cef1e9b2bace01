// SPDX-License-Identifier: BSD-3-Clause
// What formats with matrices hold of one camera, and the rig that two make. ROS, ORB-SLAM and OpenCV write the same
// values; many producers leave zeros where nothing was calibrated.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/camera_model.h"
#include "drivers/calibration/checks.h"

namespace cliquevo::drivers {

struct CameraParts {
  std::string where;                 // of its file, for messages
  CameraCalibration camera;          // focal lengths of 0 = not given
  std::vector<double> D;             // distortion as it stands, with ...
  std::string lens;                  // ... the model's name; empty = none given
  std::string D_where;               //
  std::optional<Eigen::Matrix3d> R;  // raw -> rectified; zeros = not given
  std::vector<double> P;             // 12 numbers of the rectified camera, or none; zeros = not given
  bool transposed = false;           // its camera matrix stands in the file as its transpose
  bool open = false;                 // its camera matrix ends in 0 0 0
};

// A camera matrix of 9 numbers; zeros leave the camera without one.
Result<void> put_camera_matrix(const std::vector<double>& K, const std::string& where, CameraParts& parts);
// A rotation of 9 numbers; zeros leave the camera without one.
Result<void> put_rectification(const std::vector<double>& R, const std::string& where, CameraParts& parts);

// Both cameras' lenses: by name where they have one, else by the numbers (CalibrationOptions::lens decides four terms).
Result<void> settle_lenses(CameraParts& left, CameraParts& right, const CalibrationOptions& options,
                           std::vector<std::string>& notes);

// The rig of two cameras with projections; T (left -> right, m) where the projections leave the baseline out.
Result<StereoCalibration> rig_of_projections(CameraParts left, CameraParts right,
                                             const std::optional<Eigen::Vector3d>& T, const CalibrationRequest& request,
                                             double unit_m = 1.0);
// The rig of two cameras with their pose; projections and rotations are followed where both cameras have them.
// `unit_m`: metres a unit of the pose's and the projections' lengths.
Result<StereoCalibration> rig_of_pose(CameraParts left, CameraParts right, const RigidTransform& T_right_left,
                                      const CalibrationRequest& request, double unit_m = 1.0);

}  // namespace cliquevo::drivers
