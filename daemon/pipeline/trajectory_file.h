// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as text: KITTI (a line a pose, 12 numbers, the rows of [R t]) and TUM (seconds tx ty tz qx qy qz qw) are
// read and written. Read are also tables whose heading names their columns, in any order (pose_heading.h), and the
// formats of other projects that have none (a row a format in pose_kinds.cpp).
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"

namespace cliquevo::daemon {

enum class TrajectoryFormat { kitti, tum };

struct StampedPose {
  TimestampNs stamp_ns = 0;  // 0 in KITTI files, which carry none
  RigidTransform T_world_camera;
  std::int64_t frame = -1;  // its number, in numbered trajectories
};

// What says where the camera sits on a body whose poses a file holds.
enum class BodyMounting {
  unknown,
  euroc,     // the calibration of the EuRoC recording around the file
  kitti360,  // the data set's calib_cam_to_pose.txt and perspective.txt
};

struct Trajectory {
  TrajectoryFormat format = TrajectoryFormat::kitti;  // tum: with stamps; kitti: without
  std::vector<StampedPose> poses;
  bool numbered = false;  // poses belong to the frames of these numbers, not to lines (KITTI-360)
  bool of_body = false;   // they are of another sensor's frame than the camera's (EuRoC's ground truth, ...)
  std::string body;       // which, for messages: "the IMU (VINS-Fusion)"
  BodyMounting mounting = BodyMounting::unknown;
  std::string note;  // what was concluded rather than read; empty = nothing
};

// One line of such a file, without its end. Same pose, same bytes; 13 significant digits.
std::string format_pose(TrajectoryFormat format, TimestampNs stamp_ns, const RigidTransform& T_world_camera);

// Writes a trajectory as it grows. Each line is handed to the system at once: whatever ends the program, the file holds
// whole lines up to the last pose.
class TrajectoryWriter {
 public:
  // Creates or truncates the file.
  static Result<TrajectoryWriter> open(const std::string& path, TrajectoryFormat format);

  Result<void> append(TimestampNs stamp_ns, const RigidTransform& T_world_camera);
  TrajectoryFormat format() const { return format_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const;
  };
  TrajectoryWriter() = default;
  std::string path_;
  TrajectoryFormat format_ = TrajectoryFormat::kitti;
  std::unique_ptr<std::FILE, Close> file_;
};

// Reads any of them: by the heading, where there is one that names a pose's columns, else by the count of words in a
// row and its stamp. Empty lines and lines that start with # or % are skipped; anything else that is not a pose is an
// error with its line number. Stamps without a named unit are seconds, or whole ms, us or ns since 1970 by their
// magnitude. KITTI rotations are kept as they stand in the file (rounded, so not quite orthonormal), quaternions are
// normalised, stamps must not fall.
Result<Trajectory> read_trajectory(const std::string& path);

}  // namespace cliquevo::daemon
