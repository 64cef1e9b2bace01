// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/self_check.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::vo {
namespace {

const StereoModel kModel{512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 0.0};
constexpr double kDegree = 3.14159265358979323846 / 180.0;

// What a right camera turned by these small angles (rad) shows, in px.
double rows_lower(const Eigen::Vector3d& turn, double u, double v) {
  const double x = (u - kModel.cx_px) / kModel.fx_px;
  const double y = (v - kModel.cy_px) / kModel.fy_px;
  return kModel.fy_px * ((1.0 + y * y) * turn.x() - x * y * turn.y() - x * turn.z());
}

void watch(SelfCheck& check, const Eigen::Vector3d& turn, double offset_px, int frames, unsigned seed,
           double wrong = 0.0) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(0, 511), v(0, 383), chance(0.0, 1.0), far_off(-1.5, 1.5);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (int frame = 0; frame < frames; ++frame) {
    for (int i = 0; i < 80; ++i) {
      const double at_u = u(rng), at_v = v(rng);
      const double error = rows_lower(turn, at_u, at_v) + (chance(rng) < wrong ? far_off(rng) : 0.1 * noise(rng));
      check.add_vertical(at_u, at_v, error);
    }
    check.update_vertical();
    const double used = check.disparity_error_px(kModel.cx_px, kModel.cy_px);
    check.add_offset(0.7 * (offset_px - used) + 0.1 * noise(rng), 100.0);  // a reading answers in part only
  }
}

TEST(SelfCheck, FindsTurnAndOffsetOfTheRightCameraWithinItsSigmas) {
  for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0.05, 0.0, 0.0), Eigen::Vector3d(0.0, 0.05, 0.0),
                                         Eigen::Vector3d(0.0, 0.0, 0.05), Eigen::Vector3d(-0.03, 0.06, -0.08)}) {
    SelfCheck check(kModel, {});
    watch(check, degrees * kDegree, degrees.y() * kDegree * kModel.fx_px, 300, 1);
    const CalibrationCheck found = check.result();
    EXPECT_TRUE(found.noticeable() || degrees.norm() < 0.051) << describe(found);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found.rotation_deg[k], degrees[k], 0.01) << k;
      EXPECT_LT(std::abs(found.rotation_deg[k] - degrees[k]), 3.0 * found.rotation_sigma_deg[k]) << k;
    }
  }
}

TEST(SelfCheck, FindsNothingWhereThereIsNothing) {
  SelfCheck check(kModel, {});
  EXPECT_FALSE(check.result().noticeable());
  watch(check, Eigen::Vector3d::Zero(), 0.0, 200, 2);
  const CalibrationCheck found = check.result();
  EXPECT_FALSE(found.noticeable()) << describe(found);
  EXPECT_LT(found.rotation_deg.cwiseAbs().maxCoeff(), 0.005);
  EXPECT_NE(describe(found).find("agrees"), std::string::npos);
}

TEST(SelfCheck, AThirdOfWrongRowsDoesNotMisleadIt) {
  SelfCheck check(kModel, {});
  watch(check, Eigen::Vector3d(0.04, 0.0, 0.03) * kDegree, 0.0, 200, 3, 0.33);
  EXPECT_NEAR(check.result().rotation_deg.x(), 0.04, 0.01);
  EXPECT_NEAR(check.result().rotation_deg.z(), 0.03, 0.01);
}

TEST(SelfCheck, CorrectsDisparitiesOnlyWhenConfigured) {
  VoParams params;
  params.compensate_calibration = false;
  SelfCheck check(kModel, params);
  std::mt19937 rng(4);
  for (int frame = 0; frame < 200; ++frame) {
    check.add_vertical(10.0 + frame, 100.0, 0.4);
    check.update_vertical();
    check.add_offset(0.5, 100.0);
  }
  EXPECT_EQ(check.disparity_error_px(100.0, 300.0), 0.0);
  EXPECT_NEAR(check.result().disparity_offset_px, 0.5, 0.02) << "measured all the same";
  EXPECT_FALSE(check.result().compensated);
  EXPECT_NE(describe(check.result()).find("calibrate again"), std::string::npos);
}

TEST(SelfCheck, RowsAreJudgedWhereFeaturesWereSeen) {
  SelfCheck check(kModel, {});
  std::mt19937 rng(6);
  std::uniform_real_distribution<double> u(100, 400), v(150, 300);
  for (int frame = 0; frame < 100; ++frame) {
    for (int i = 0; i < 80; ++i) {  // bends upward in the middle third, which gives no evidence on the corners
      const double at_u = u(rng), at_v = v(rng);
      const double x = (at_u - kModel.cx_px) / kModel.fx_px;
      check.add_vertical(at_u, at_v, 3.0 * x * x);
    }
    check.update_vertical();
  }
  const double corner = check.vertical_error_px(0.0, 0.0);
  const CalibrationCheck found = check.result();
  EXPECT_GT(std::abs(corner), 0.5);
  EXPECT_LT(found.vertical_most_px, 0.35);
  EXPECT_FALSE(found.noticeable()) << describe(found);
}

TEST(SelfCheck, IsUnsettledWhileItLearnsAndLessUncertainAfterwards) {
  SelfCheck check(kModel, {});
  const double at_first = check.offset_variance_px2();
  EXPECT_EQ(check.unsettled(), 1.0);
  double most = 1.0;
  for (int frame = 0; frame < 600; ++frame) {
    check.add_offset(0.5 - check.disparity_error_px(kModel.cx_px, kModel.cy_px), 400.0);
    most = std::max(most, check.unsettled());
  }
  EXPECT_GT(most, 2.0) << "half a pixel is news";
  EXPECT_NEAR(check.unsettled(), 1.0, 0.1);
  EXPECT_LT(check.offset_variance_px2(), 0.1 * at_first);
}

TEST(SelfCheck, UnusableReadingsChangeNothing) {
  SelfCheck check(kModel, {});
  check.add_offset(std::nan(""), 100.0);
  check.add_offset(1.0, 0.0);
  check.add_offset(1.0, -5.0);
  check.update_vertical();
  EXPECT_EQ(check.result().disparity_offset_px, 0.0);
  EXPECT_EQ(check.result().frames, 0);
}

}  // namespace
}  // namespace cliquevo::vo
