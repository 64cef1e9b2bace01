// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/camera_model.h"

#include <limits>

#include <gtest/gtest.h>

namespace cliquevo {
namespace {

StereoModel good() { return {512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 0.0}; }

TEST(StereoModel, AcceptsAnOrdinaryPairAndTriangulatesIt) {
  const StereoModel m = good();
  ASSERT_TRUE(m.check().ok());
  const Eigen::Vector3d p = m.triangulate(255.5 + 56.0, 191.5, 6.72);
  EXPECT_NEAR(p.z(), 10.0, 1e-9);
  EXPECT_NEAR(p.x(), 1.0, 1e-9);
  EXPECT_NEAR(m.depth_error_m(10.0, 0.672), 1.0, 1e-9);
}

TEST(StereoModel, ItsFieldsOfViewAreThoseOfAPinhole) {
  StereoModel m = good();
  m.fx_px = 256.0;
  m.fy_px = 192.0;
  m.cx_px = 0.5 * m.width;
  m.cy_px = 0.5 * m.height;
  constexpr double kQuarterTurn = 1.57079632679489661923;
  EXPECT_NEAR(m.horizontal_fov_rad(), kQuarterTurn, 0.01);
  EXPECT_NEAR(m.vertical_fov_rad(), kQuarterTurn, 0.01);
}

TEST(StereoModel, NamesWhatIsImpossible) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const auto& spoil : std::initializer_list<void (*)(StereoModel&)>{
           [](StereoModel& m) { m.baseline_m = 0.0; }, [](StereoModel& m) { m.baseline_m = -0.1; },
           [](StereoModel& m) { m.fx_px = 0.0; }, [](StereoModel& m) { m.width = 0; },
           [](StereoModel& m) { m.baseline_m = 120.0; }, [](StereoModel& m) { m.fx_px = 1e9; }}) {
    StereoModel m = good();
    spoil(m);
    ASSERT_FALSE(m.check().ok());
    EXPECT_FALSE(m.check().error().where.empty());
  }
  StereoModel m = good();
  m.cx_px = nan;
  EXPECT_FALSE(m.check().ok());
}

}  // namespace
}  // namespace cliquevo
