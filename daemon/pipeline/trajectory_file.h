// SPDX-License-Identifier: BSD-3-Clause
// Trajectories as text: KITTI (a line a pose, 12 numbers, the rows of [R t]) and TUM (seconds tx ty tz qx qy qz qw). As
// references also EuRoC's ground truth (data.csv: ns, position, quaternion with w first, ...), KITTI-360's
// cam0_to_world.txt (number of the frame, 16 numbers) and its poses.txt (number of the frame, 12 numbers).
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
const char* trajectory_format_name(TrajectoryFormat format);

struct StampedPose {
  TimestampNs stamp_ns = 0;  // 0 in KITTI files, which carry none
  RigidTransform T_world_camera;
  std::int64_t frame = -1;  // its number, in numbered trajectories
};

struct Trajectory {
  TrajectoryFormat format = TrajectoryFormat::kitti;
  std::vector<StampedPose> poses;
  bool numbered = false;  // poses belong to the frames of these numbers, not to lines (KITTI-360)
  bool of_body =
      false;  // they are of another sensor's frame than the camera's (EuRoC's ground truth, KITTI-360's poses.txt)
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

// Reads any of them, recognised by the count of numbers in a line. Empty lines and lines that start with # are
// skipped; anything else that is not a pose is an error with its line number. KITTI rotations are kept as they stand
// in the file (rounded, so not quite orthonormal), TUM quaternions are normalised, TUM stamps must not fall.
Result<Trajectory> read_trajectory(const std::string& path);

}  // namespace cliquevo::daemon
