// SPDX-License-Identifier: BSD-3-Clause
// Trajectory files of every format: finite poses on earth, rotations that are some, stamps and numbers in order.
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cliquevo;
  static const int file = memfd_create("trajectory", MFD_CLOEXEC);
  if (file < 0 || ftruncate(file, 0) != 0) std::abort();
  for (std::size_t at = 0; at < size;) {
    const ssize_t written = pwrite(file, data + at, size - at, static_cast<off_t>(at));
    if (written <= 0) std::abort();
    at += static_cast<std::size_t>(written);
  }
  const auto trajectory = daemon::read_trajectory("/proc/self/fd/" + std::to_string(file));
  if (!trajectory) return fuzz::expect_clear(trajectory.error()), 0;
  fuzz::expect(!trajectory->poses.empty(), "a trajectory has poses");
  const daemon::StampedPose* last = nullptr;
  for (const daemon::StampedPose& pose : trajectory->poses) {
    const Eigen::Matrix3d& R = pose.T_world_camera.R;
    fuzz::expect(pose.T_world_camera.is_finite() && pose.T_world_camera.t.norm() < 1e9, "positions are on earth");
    fuzz::expect((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 0.1, "rotations are some");
    fuzz::expect(last == nullptr || pose.stamp_ns >= last->stamp_ns, "stamps do not fall");
    last = &pose;
  }
  return 0;
}
