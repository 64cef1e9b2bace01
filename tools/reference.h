// SPDX-License-Identifier: BSD-3-Clause
// Finds what a replayed trajectory can be held against.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/run_log.h"

namespace cliquevo::tools {

// A trajectory file that is held to be true, as poses of the rectified left camera. EuRoC's ground truth is of the
// body: where the camera sits is read from cam0/sensor.yaml beside its folder (or T_cam_imu of the recording's Kalibr
// file, as TUM VI has it), and how it is turned by rectification from `calibration` where given, else from that file.
// KITTI-360's poses.txt is of the vehicle: calib_cam_to_pose.txt and perspective.txt, beside it or in the data set's
// `calibration`, give the left camera's place. Poses of other bodies are refused.
Result<daemon::Trajectory> read_reference(const std::string& path, const StereoCalibration* calibration = nullptr);

// A reference and the trajectory that is held against it, in frames that can be compared: where both are of a body,
// both stay so; else the reference is as read_reference() has it. `frame_is_stated`: by the user; then the poses of a
// body on which no camera is known to sit stand as they are.
struct ReferenceAndEstimate {
  daemon::Trajectory reference;
  daemon::Trajectory estimate;
  std::vector<Error> warnings;  // what was concluded, or cannot be decided; printed as they are
};
Result<ReferenceAndEstimate> read_compared(const std::string& reference, const std::string& estimate,
                                           bool frame_is_stated);

// A file that recordings bring along as their reference (poses.txt, groundtruth.tum, EuRoC's ground truth, TUM VI's
// mocap0/data.csv, KITTI-360's cam0_to_world.txt or poses.txt); empty when there is none.
std::string reference_beside(const std::string& recording);

// The poses of a file that belong to the frames of the run: by the pairs' positions in the recording (KITTI;
// KITTI-360's numbers count from the recording's first image), by stamp (TUM, EuRoC). Fails when the file cannot be
// read or does not reach as far as the run.
Result<RunReference> reference_from_file(const std::string& path, const std::vector<FrameRecord>& frames,
                                         const drivers::SourceInfo& info);
// What the source itself knew to be true.
std::optional<RunReference> reference_from_truth(const std::vector<FrameRecord>& frames);

}  // namespace cliquevo::tools
