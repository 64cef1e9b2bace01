// SPDX-License-Identifier: BSD-3-Clause
// What ordinary driving has shown of the calibration's errors.
#pragma once

#include <string>

#include <Eigen/Core>

namespace cliquevo::vo {

// Errors of the right image against the rectification, with their standard deviations.
struct CalibrationCheck {
  int frames = 0;  // that contributed
  // Row in the right image less row in the left one: at the principal point, and by how much it grows over the whole
  // width and the whole height of the image; the largest error in those parts of the image where features were seen.
  double vertical_px = 0.0;         // at the principal point
  double vertical_across_px = 0.0;  // growth over the width
  double vertical_down_px = 0.0;    // growth over the height
  double vertical_most_px = 0.0;    // largest where features were seen
  double vertical_sigma_px = 0.0;   // standard deviation
  // By how much disparities at the principal point are too large.
  double disparity_offset_px = 0.0;
  double disparity_offset_sigma_px = 0.0;  // its standard deviation
  // The turn of the right camera about its x, y and z axes that would explain these errors.
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_sigma_deg = Eigen::Vector3d::Zero();  // its standard deviation
  // The right camera's focal length over the left one's, less 1, as rows show it; of a scene that is a level ground, a
  // baseline that points up or down looks the same.
  double focal_ratio_error = 0.0;
  double focal_ratio_sigma = 0.0;  // its standard deviation
  bool compensated = false;        // the odometry corrects for it

  // Plainly there, and large enough to be worth a new calibration.
  bool noticeable() const;
};

// One plain sentence, with the suggested correction where one is due.
std::string describe(const CalibrationCheck& check);

}  // namespace cliquevo::vo
