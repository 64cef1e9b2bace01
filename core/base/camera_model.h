// SPDX-License-Identifier: BSD-3-Clause
// Cameras: the raw calibration of a stereo pair, and the rectified pair that stereo and odometry work on.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"

namespace cliquevo {

// A rectified stereo pair: rows are epipolar lines, f and cy are the same. Camera frame: Z forward, X right, Y down;
// origin in the left camera. disparity d = u_left - u_right; Z = fx * baseline / (d + doffs).
struct StereoModel {
  int width = 0;            // px
  int height = 0;           // px
  double fx_px = 0.0;       // focal length
  double fy_px = 0.0;       // focal length
  double cx_px = 0.0;       // principal point of the left image
  double cy_px = 0.0;       // principal point of both images
  double baseline_m = 0.0;  // from camera to camera
  double doffs_px = 0.0;    // cx_right - cx_left
  // Rolling shutter: from the exposure of the first row to that of the last; the middle row's is the stamp. 0: all rows
  // at once.
  double readout_s = 0.0;

  // Names what is wrong: sizes, focal lengths and baseline must be positive and finite, the field of view sane.
  Result<void> check() const;
  // Depth in m of a disparity in px; the disparity (+ doffs) must be > 0.
  double depth_m(double disparity_px) const { return fx_px * baseline_m / (disparity_px + doffs_px); }
  // Standard deviation of the depth at z for a disparity error, first order: z^2 / (f b) * sigma_d.
  double depth_error_m(double z_m, double sigma_disparity_px) const {
    return z_m * z_m / (fx_px * baseline_m) * sigma_disparity_px;
  }
  // Over the whole width.
  double horizontal_fov_rad() const;
  // Over the whole height.
  double vertical_fov_rad() const;
  // Point in the left camera frame from left pixel and disparity.
  Eigen::Vector3d triangulate(double u, double v, double disparity_px) const {
    const double z = depth_m(disparity_px);
    return {(u - cx_px) * z / fx_px, (v - cy_px) * z / fy_px, z};
  }
  // (u, v, disparity) in px of a point in the left camera frame, z > 0.
  Eigen::Vector3d project(const Eigen::Vector3d& p) const {
    return {fx_px * p.x() / p.z() + cx_px, fy_px * p.y() / p.z() + cy_px, fx_px * baseline_m / p.z() - doffs_px};
  }
};

// Lens models; see CameraCalibration::coefficients.
enum class Distortion {
  none,              // a pinhole
  plumb_bob,         // k1 k2 p1 p2 [k3], as OpenCV
  rational,          // k1 k2 p1 p2 k3 k4 k5 k6, as OpenCV
  equidistant,       // Kannala-Brandt fisheye: k1 k2 k3 k4, as OpenCV's fisheye and Kalibr's "equidistant"
  thin_prism,        // rational, then s1 s2 s3 s4 tau_x tau_y in `prism`, as OpenCV
  unified,           // Mei's omnidirectional model: xi, then k1 k2 p1 p2 behind the sphere
  extended_unified,  // Khomutenko et al. 2016: alpha, beta
  double_sphere,     // Usenko et al. 2018: xi, alpha
};

// One raw camera.
struct CameraCalibration {
  int width = 0;                             // px
  int height = 0;                            // px
  double fx_px = 0.0;                        // focal length
  double fy_px = 0.0;                        // focal length
  double cx_px = 0.0;                        // principal point
  double cy_px = 0.0;                        // principal point
  Distortion distortion = Distortion::none;  // of the lens
  std::array<double, 8> coefficients{};      // unused ones are 0
  std::array<double, 6> prism{};             // of Distortion::thin_prism
};

// Rectification that a calibration file prescribes (KITTI's R_rect and P_rect, ROS's R and P).
struct PrescribedRectification {
  Eigen::Matrix3d R_left = Eigen::Matrix3d::Identity();   // raw camera -> rectified camera
  Eigen::Matrix3d R_right = Eigen::Matrix3d::Identity();  // raw camera -> rectified camera
  StereoModel model;                                      // the rectified pair
};

// Two raw cameras and how they sit to each other.
struct StereoCalibration {
  CameraCalibration left;                             // as it grabs
  CameraCalibration right;                            // as it grabs
  RigidTransform T_right_left;                        // point in the left raw camera -> right raw camera
  double readout_s = 0.0;                             // rolling shutter, first row to last; 0: all rows at once
  bool exchanged = false;                             // the first camera of its file is the right one
  bool rectified = false;                             // images already are: use `prescribed->model`, warp nothing
  std::optional<PrescribedRectification> prescribed;  // when set it is used; a rectification of our own otherwise
  std::string source;                                 // the file it came from, for messages
  std::vector<std::string> notes;                     // what was assumed in reading it, each a line for the user
};

}  // namespace cliquevo
