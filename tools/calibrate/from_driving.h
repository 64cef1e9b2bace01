// SPDX-License-Identifier: BSD-3-Clause
// A calibration corrected by ordinary driving: what the self-check finds between the cameras is taken out, and the
// drive is run again, until nothing is left.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/vo/self_check.h"
#include "daemon/pipeline/config.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

using OpenSource = std::function<Result<std::unique_ptr<drivers::FrameSource>>()>;

// One run over the whole recording.
struct DrivenRun {
  vo::CalibrationCheck check;  // at its end, against the calibration of this run
  std::int64_t frames = 0;
  std::int64_t valid = 0;
  double way_m = 0.0;
  double reprojection_px = 0.0;             // mean over valid frames
  std::optional<double> end_error_percent;  // of the way, where the truth is known
};

struct DrivenCalibration {
  StereoCalibration calibration;
  std::vector<DrivenRun> runs;  // the first with the calibration as it was, the last with this one
  Eigen::Vector3d turned_deg = Eigen::Vector3d::Zero();  // the right camera, about its rectified axes, in all
  Eigen::Vector3d sigma_deg = Eigen::Vector3d::Zero();
  double focal_ratio = 1.0;  // of the right camera's new focal lengths over the old ones
  double focal_ratio_sigma = 0.0;
  bool changed = false;
};

// Fails where the drive shows too little.
Result<DrivenCalibration> calibrate_from_driving(const OpenSource& open, const daemon::Config& config);

// The same rig with its right camera turned, in the rectified right camera's axes. As raw cameras, also where the
// calibration was of rectified images.
StereoCalibration with_right_camera_turned(const StereoCalibration& calibration, const Eigen::Vector3d& turn_rad);

// The same rig with both focal lengths of its right camera times this.
StereoCalibration with_right_focal_scaled(const StereoCalibration& calibration, double ratio);

}  // namespace cliquevo::tools
