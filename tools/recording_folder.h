// SPDX-License-Identifier: BSD-3-Clause
// Pairs as a folder of images with their calibration: KITTI odometry layout for rectified pairs, EuRoC layout for pairs
// as grabbed.
#pragma once

#include <string>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::tools {

enum class FolderLayout { kitti, euroc };

class RecordingFolder {
 public:
  // Makes the folders. `folder` must not exist or be empty. KITTI's layout takes a rectified calibration alone.
  static Result<RecordingFolder> create(const std::string& folder, FolderLayout layout,
                                        const StereoCalibration& calibration, double rate_hz);

  Result<void> add(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right, TimestampNs stamp_ns);
  // Calibration and times.
  Result<void> finish();

 private:
  RecordingFolder() = default;

  std::string folder_;
  FolderLayout layout_ = FolderLayout::kitti;
  StereoCalibration calibration_;
  double rate_hz_ = 0.0;
  std::string times_;
  std::int64_t count_ = 0;
};

// P0 and P1 of a rectified pair, as KITTI's calib.txt.
std::string kitti_calibration(const StereoModel& model);
// One camera as ROS' camera_info file, with its prescribed rectification.
std::string ros_camera_info(const StereoCalibration& calibration, bool left);
Result<void> write_picture(const std::string& path, ImageView<const std::uint8_t> grey);
Result<void> write_picture(const std::string& path, ImageView<const std::uint16_t> grey);
Result<void> write_text(const std::string& path, const std::string& text);

}  // namespace cliquevo::tools
