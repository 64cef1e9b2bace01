// SPDX-License-Identifier: BSD-3-Clause
// Small made-up recordings and calibrations on disk.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "core/base/camera_model.h"
#include "drivers/recording.h"
#include "tests/support/subprocess.h"

namespace cliquevo::test {

// A file with this content; folders are made as needed. Returns its path.
std::string write_file(const std::string& path, const std::string& content);

// A grey textured image that differs with `seed`; the extension chooses the format.
void write_image(const std::string& path, int width, int height, int seed);
// What write_image() stores, for lossless formats.
int pixel_of(int x, int y, int seed);
// As write_image(), in colour (blue, green, red).
void write_colour_image(const std::string& path, int width, int height, int blue, int green, int red);
// Cuts a file to a part of its length.
void truncate_file(const std::string& path, double part);

// calib.txt of a rectified pair.
std::string kitti_calibration(double focal_px = 100.0, double cx_left_px = 31.5, double cx_right_px = 31.5,
                              double baseline_m = 0.5);
// A KITTI odometry folder with `count` pairs of 64x48 at 10 Hz; the seed of image i is 2i (left) and 2i + 1 (right).
std::string write_kitti_odometry(const std::string& folder, int count);

// A raw rig as real ones are: rotated against each other, unequal cameras; and its calibration in each format.
struct Rig {
  int width = 640;
  int height = 480;
  Eigen::Matrix3d K_left, K_right;
  std::vector<double> D_left, D_right;  // plumb bob, five
  RigidTransform T_right_left;
  Eigen::Matrix3d R1, R2;  // OpenCV's rectification of it
  Eigen::Matrix<double, 3, 4> P1, P2;
};
Rig make_rig();
std::string list_of(const Eigen::MatrixXd& m);  // "1, 2, 3", row-major, all digits
std::string list_of(const std::vector<double>& v);
std::string euroc_yaml(const Rig& rig, bool left);
std::string kalibr_yaml(const Rig& rig, const std::string& model = "radtan");
std::string ros_yaml(const Rig& rig, bool left);
std::string opencv_yaml(const Rig& rig, bool rectification);
std::string kitti_raw_txt(const Rig& rig);

// The error is one clear line that holds all of the fragments.
void expect_clear(const Error& error, const std::vector<std::string>& fragments);
// Opening fails with such an error.
void expect_open_error(const drivers::RecordingOptions& options, const std::vector<std::string>& fragments);
void expect_open_error(const std::string& path, const std::vector<std::string>& fragments);

}  // namespace cliquevo::test
