// SPDX-License-Identifier: BSD-3-Clause
// Images as a camera of your own delivers them: its calibration, its buffers without a copy, and what to do with the
// frames that fail.
#include <cstdio>

#include <cliquevo/odometry.h>

#include "camera.h"

namespace {

int fail(const cliquevo::Error& error) {
  std::fprintf(stderr, "%s\n", error.line().c_str());
  return 1;
}

// Each check's value beside what is allowed: why a frame failed.
void print_reasons(const cliquevo::vo::Estimate& estimate) {
  std::printf("  %s\n", cliquevo::vo::status_name(estimate.status));
  for (std::size_t k = 0; k < cliquevo::vo::kChecks; ++k) {
    const auto check = static_cast<cliquevo::vo::Check>(k);
    if (estimate.checks[check].fails()) {
      std::printf("  %s: %.2f times what is allowed\n", cliquevo::vo::check_name(check),
                  estimate.checks[check].ratio());
    }
  }
}

}  // namespace

int main() {
  cliquevo::OdometryParams params;
  params.stereo.num_disparities = 64;  // what is nearer than fx * baseline / 64 is not seen
  auto odometry = cliquevo::Odometry::make(Camera::calibration(), params);
  if (!odometry) return fail(odometry.error());

  Camera camera;
  int valid = 0;
  for (int frame = 0; frame < 6; ++frame) {
    cliquevo::TimestampNs stamp_ns = 0;
    const std::uint8_t* both = camera.grab(stamp_ns);
    // Rows of the two images lie 2 * kWidth pixels apart: that is the stride of a view, nothing is copied.
    const cliquevo::ImageView<const std::uint8_t> left(both, Camera::kWidth, Camera::kHeight, 2 * Camera::kWidth);
    const cliquevo::ImageView<const std::uint8_t> right(both + Camera::kWidth, Camera::kWidth, Camera::kHeight,
                                                        2 * Camera::kWidth);
    const auto estimate = odometry->step(left, right, stamp_ns);
    if (!estimate) return fail(estimate.error());  // this pair could not be used; the next one may be
    std::printf("z %.4f m, +- %.4f m, quality %d\n", estimate->T_world_camera.t.z(),
                std::sqrt(estimate->covariance(2, 2)), estimate->quality);
    if (estimate->status == cliquevo::vo::Status::valid)
      ++valid;
    else if (frame > 0)
      print_reasons(*estimate);
  }
  std::printf("calibration: %s\n", cliquevo::vo::describe(odometry->estimate().calibration).c_str());
  const double error_m = std::abs(odometry->estimate().T_world_camera.t.norm() - 5 * Camera::kStepM);
  return valid == 5 && error_m < 0.01 ? 0 : 1;
}
