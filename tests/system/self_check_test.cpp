// SPDX-License-Identifier: BSD-3-Clause
// The calibration self-check on rendered courses whose right camera is turned by a twentieth of a degree.
#include "core/vo/self_check.h"

#include <cmath>

#include <fmt/format.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

struct Ride {
  vo::CalibrationCheck check;
  double end_error_m = 0.0;
  int failed = 0;
};

Ride ride(const std::string& text) {
  Ride out;
  const auto options = drivers::parse_simulator_options(text);
  EXPECT_TRUE(options.ok()) << text;
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  auto pipeline = daemon::FramePipeline::make({}, (*simulator)->info());
  EXPECT_TRUE(pipeline.ok());
  drivers::StereoPair pair;
  RigidTransform first, last;
  for (int i = 0;; ++i) {
    const auto more = (*simulator)->next(pair);
    if (!more.ok() || !*more) break;
    EXPECT_TRUE(pipeline->process(pair).ok());
    const vo::Status status = pipeline->estimate().status;
    out.failed += status != vo::Status::valid && status != vo::Status::no_data ? 1 : 0;
    if (i == 0) first = *pair.truth_T_world_camera;
    last = *pair.truth_T_world_camera;
  }
  const vo::Estimate& estimate = pipeline->estimate();
  out.check = estimate.calibration;
  out.end_error_m = ((first.inverse() * last).t - estimate.T_world_camera.t).norm();
  return out;
}

void expect_found(const std::string& course) {
  const Ride good = ride(course);
  EXPECT_LT(good.check.rotation_deg.cwiseAbs().maxCoeff(), 0.01);
  EXPECT_FALSE(good.check.noticeable()) << vo::describe(good.check);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    turn[axis] = 0.05;
    const Ride turned = ride(fmt::format("{},misalign_right_deg={}:{}:{}", course, turn.x(), turn.y(), turn.z()));
    EXPECT_EQ(turned.failed, 0);
    const Eigen::Vector3d error = turned.check.rotation_deg - turn;
    fmt::print(
        "axis {}: found {:.4f} {:.4f} {:.4f} +- {:.4f} {:.4f} {:.4f} degrees; end {:.4f} m, calibrated {:.4f} m\n",
        axis, turned.check.rotation_deg.x(), turned.check.rotation_deg.y(), turned.check.rotation_deg.z(),
        turned.check.rotation_sigma_deg.x(), turned.check.rotation_sigma_deg.y(), turned.check.rotation_sigma_deg.z(),
        turned.end_error_m, good.end_error_m);
    EXPECT_LT(error.cwiseAbs().maxCoeff(), 0.01) << axis;
    EXPECT_TRUE((error.cwiseAbs().array() < 3.0 * turned.check.rotation_sigma_deg.array()).all()) << axis;
    // A frame's own error is about 0.1 mm: no less is required.
    EXPECT_LT(turned.end_error_m, 1.5 * good.end_error_m + 0.002) << axis;
  }
}

TEST(SelfCheckOnTheSimulator, ATurnedRightCameraIsFoundAndDoesNotSpoilTheMotion) {
#ifdef CLIQUEVO_LONG
  expect_found("frames=500");
#else
  expect_found("frames=80,width=384,height=288,focal_px=420");
#endif
}

}  // namespace
}  // namespace cliquevo::test
