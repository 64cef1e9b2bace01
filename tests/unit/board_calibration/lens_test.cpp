// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/lens.h"

#include <gtest/gtest.h>

#include "stereo/camera_projection.h"

namespace cliquevo::calibration {
namespace {

LensVector some_lens(const LensModel& model) {
  LensVector lens = LensVector::Zero();
  lens.head<4>() << 400.0, 410.0, 320.0, 240.0;
  for (int i = 0; i < model.coefficients; ++i) lens(kFocalAndCentre + i) = 0.004 * (i + 1) * (i % 2 == 0 ? 1.0 : -1.0);
  return lens;
}

TEST(Lens, IsTheOneThatTheOdometryRectifiesWith) {
  for (const LensModel& model : lens_models()) {
    const LensVector lens = some_lens(model);
    const stereo::CameraProjection camera(to_camera(model, lens, 640, 480));
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.3, -0.2, 1.1), {0.0, 0.0, 1.0}, {-0.5, 0.4, 0.9}}) {
      const auto px = camera.project(p);
      ASSERT_TRUE(px.has_value()) << model.name;
      EXPECT_NEAR((project_with_derivatives(model, lens, p).px - *px).norm(), 0.0, 1e-9) << model.name;
    }
  }
}

TEST(Lens, DerivativesAreThoseOfSmallSteps) {
  constexpr double kStep = 1e-6;
  const Eigen::Vector3d p(0.3, -0.2, 1.1);
  for (const LensModel& model : lens_models()) {
    const LensVector lens = some_lens(model);
    const Projection at = project_with_derivatives(model, lens, p);
    for (int i = 0; i < model.size(); ++i) {
      LensVector moved = lens;
      moved(i) += kStep;
      const Eigen::Vector2d slope = (project_with_derivatives(model, moved, p).px - at.px) / kStep;
      EXPECT_NEAR((slope - at.by_lens.col(i)).norm(), 0.0, 1e-3) << model.name << " " << model.parameter_name(i);
    }
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector3d moved = p;
      moved(i) += kStep;
      const Eigen::Vector2d slope = (project_with_derivatives(model, lens, moved).px - at.px) / kStep;
      EXPECT_NEAR((slope - at.by_point.col(i)).norm(), 0.0, 1e-2) << model.name;
    }
  }
}

TEST(Lens, APinholeSeesNothingBehindItAndAFisheyeBesideIt) {
  const LensModel& pinhole = *find_lens_model("rational");
  EXPECT_FALSE(project_with_derivatives(pinhole, some_lens(pinhole), {0.1, 0.1, -1.0}).seen);
  const LensModel& fisheye = *find_lens_model("equidistant");
  EXPECT_TRUE(project_with_derivatives(fisheye, some_lens(fisheye), {1.0, 0.0, -0.05}).seen);
}

}  // namespace
}  // namespace cliquevo::calibration
