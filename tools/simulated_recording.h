// SPDX-License-Identifier: BSD-3-Clause
// A simulated course as a recording on disk: KITTI odometry layout for a rectified pair, EuRoC layout for a raw one;
// poses.txt (KITTI: 12 numbers a line, rectified left camera in its first frame) and disp_0/ (16-bit PNG, px * 256,
// 0 = unknown) beside it.
#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"
#include "drivers/simulator.h"
#include "tools/recording_folder.h"

namespace cliquevo::tools {

class SimulatedRecording {
 public:
  // Makes the folders. `folder` must not exist or be empty.
  static Result<SimulatedRecording> create(const std::string& folder, const StereoCalibration& calibration,
                                           double rate_hz);

  // One pair and its truth.
  Result<void> add(const drivers::StereoPair& pair, ImageView<const float> disparity);
  // Calibration, times and poses.
  Result<void> finish();

 private:
  SimulatedRecording(std::string folder, const StereoCalibration& calibration, RecordingFolder images)
      : folder_(std::move(folder)), calibration_(calibration), images_(std::move(images)) {}

  std::string folder_;
  StereoCalibration calibration_;
  RecordingFolder images_;
  std::string poses_;
  std::int64_t first_stamp_ns_ = 0;
  std::int64_t count_ = 0;
};

// 16-bit picture of a disparity, px * 256; NaN and what does not fit become 0.
Image<std::uint16_t> disparity_to_file_units(ImageView<const float> disparity);

}  // namespace cliquevo::tools
