// SPDX-License-Identifier: BSD-3-Clause
// Rectified stereo images in, poses out. The lines between the marks are all that the library needs.
#include <cmath>
#include <cstdio>

#include <cliquevo/odometry.h>

#include "wall.h"

namespace {

int fail(const cliquevo::Error& error) {
  std::fprintf(stderr, "%s\n", error.line().c_str());
  return 1;
}

}  // namespace

int main() {
  // [ten lines]
  cliquevo::StereoModel model{.width = 320, .height = 240, .fx_px = 300, .fy_px = 300, .cx_px = 159.5, .cy_px = 119.5};
  model.baseline_m = 0.12;
  auto odometry = cliquevo::Odometry::make(model);
  if (!odometry) return fail(odometry.error());
  Wall camera(model, 5);
  while (camera.next()) {
    auto estimate = odometry->step(camera.left(), camera.right(), camera.stamp_ns());
    if (!estimate) return fail(estimate.error());
    const Eigen::Vector3d& t = estimate->T_world_camera.t;  // m: X right, Y down, Z forward
    std::printf("%s %.4f %.4f %.4f\n", cliquevo::vo::status_name(estimate->status), t.x(), t.y(), t.z());
  }
  // [end]
  const auto& last = odometry->estimate();
  const double error_m = (last.T_world_camera.t - Eigen::Vector3d(0.0, 0.0, 4 * Wall::kStepM)).norm();
  return last.status == cliquevo::vo::Status::valid && error_m < 0.01 ? 0 : 1;
}
