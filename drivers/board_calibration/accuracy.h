// SPDX-License-Identifier: BSD-3-Clause
// What a calibration is worth, in the units of those who use it.
#pragma once

#include <array>

#include "drivers/board_calibration/solve.h"

namespace cliquevo::calibration {

inline constexpr std::array<double, 3> kJudgedDepths_m{5.0, 10.0, 20.0};

// One standard deviation each, from the covariance of all parameters together.
struct Accuracy {
  std::array<double, 3> depth_m{};  // of the depth of what is so far away (kJudgedDepths_m), RMS over the image
  double rotation_deg = 0.0;        // between the cameras
  double baseline_m = 0.0;
  double drift_percent = 0.0;  // of the length of a way: error common to all depths at 5 m
};
Accuracy accuracy(const Rig& rig, const Eigen::Matrix<double, kShared, kShared>& covariance);

// Where in the image corners were seen, and how the board was held.
struct Coverage {
  std::array<double, 2> filled{};  // share of 8 x 6 cells with a corner, by Side
  double tilt_deg = 0.0;           // largest between two views
  double nearest_m = 0.0;
  double farthest_m = 0.0;
  std::string hole;  // "upper left of the left image", empty: none
};
Coverage coverage(const Board& board, const Solution& solution);

// Another calibration of the same cameras, held against this one.
struct Movement {
  double rows_px = 0.0;                  // RMS difference of rows that it leaves between corresponding pixels
  std::array<double, 3> depth_m{};       // mean error of its depths (kJudgedDepths_m)
  std::array<double, 3> depth_sigmas{};  // the same in standard deviations of this one
  double rotation_deg = 0.0;             // between the cameras, from one to the other
};
Movement movement(const Rig& rig, const Eigen::Matrix<double, kShared, kShared>& covariance,
                  const StereoCalibration& other);

}  // namespace cliquevo::calibration
