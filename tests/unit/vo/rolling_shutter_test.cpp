// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/rolling_shutter.h"

#include <random>

#include <gtest/gtest.h>

#include "core/vo/frame.h"

namespace cliquevo::vo {
namespace {

StereoModel rolling_model() {
  StereoModel m;
  m.width = 640, m.height = 480;
  m.fx_px = m.fy_px = 500.0;
  m.cx_px = 319.5, m.cy_px = 239.5;
  m.baseline_m = 0.2;
  m.readout_s = 0.02;
  return m;
}

// Points seen by two frames, the second of which turns by `turn` during its exposure: what its rows show.
std::vector<Observation> turning_views(const StereoModel& m, const RigidTransform& T_ref_cur, const Velocity& turn) {
  const RollingShutter shutter(m);
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(40.0, 600.0), v(40.0, 440.0), d(4.0, 40.0);
  std::vector<Observation> out;
  for (int i = 0; i < 300; ++i) {
    Observation o;
    o.uvd_ref = {u(rng), v(rng), d(rng)};
    const Eigen::Vector3d at_stamp = T_ref_cur.inverse() * m.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    o.uvd_cur = m.project(at_stamp);
    for (int k = 0; k < 5; ++k) {  // the row that sees it is the row where it is seen
      o.uvd_cur = m.project(shutter.T_stamp_row(turn, o.uvd_cur.y()).inverse() * at_stamp);
    }
    o.inlier = true;
    out.push_back(o);
  }
  return out;
}

TEST(RollingShutter, WhatARowSeesIsMovedToTheStamp) {
  const StereoModel m = rolling_model();
  const RollingShutter shutter(m);
  Velocity velocity;
  velocity << 0.3, -0.1, 1.5, 0.2, -0.4, 0.1;
  const RigidTransform T;
  for (const Observation& o : turning_views(m, T, velocity)) {
    EXPECT_NEAR((shutter.at_stamp(m, velocity, o.uvd_cur) - o.uvd_ref).norm(), 0.0, 1e-6);
  }
  EXPECT_NEAR(shutter.later_s(239.5), 0.0, 1e-12) << "the middle row is exposed at the stamp";
  EXPECT_NEAR(shutter.later_s(479.5) - shutter.later_s(-0.5), 0.02, 1e-12);
}

TEST(RollingShutter, ATurnDuringTheExposureIsFoundFromTheRows) {
  const StereoModel m = rolling_model();
  RigidTransform T;
  T.t = {0.01, -0.02, 0.12};
  T.R = so3_exp({0.004, -0.006, 0.002});
  Velocity turn = Velocity::Zero();
  turn.tail<3>() << 0.04, -0.06, 0.05;
  const std::vector<Observation> observations = turning_views(m, T, turn);
  Motion motion;
  motion.T_prev_cur = T;
  const TurnFit fit = fit_turn(observations, {RigidTransform{}}, motion, m, {0.3, 0.3, 0.0}, 1.0);
  EXPECT_NEAR((fit.rate - turn.tail<3>()).norm(), 0.0, 2e-3);
  EXPECT_GT(fit.covariance.trace(), 0.0) << "a turn that is unknown makes the motion less known";
  const TurnFit none = fit_turn(observations, {RigidTransform{}}, motion, m, {0.3, 0.3, 0.0}, 1e-6);
  EXPECT_NEAR(none.rate.norm(), 0.0, 1e-4) << "where none is expected, none is found";
}

TEST(RollingShutter, VelocitiesLieBetweenAndBeyondTheMotions) {
  const VoParams params;
  Frame reference(params), current(params);
  reference.stamp_ns = 0, current.stamp_ns = 100'000'000;
  reference.velocity_before << 0.0, 0.0, 1.0, 0.0, 0.1, 0.0;
  RigidTransform T;
  T.t = {0.0, 0.0, 0.2};  // 2 m/s
  T.R = so3_exp({0.0, 0.03, 0.0});
  const Velocities v = velocities(reference, current, T);
  EXPECT_NEAR(v.before.z(), 2.0, 1e-12);
  EXPECT_NEAR(v.reference.z(), 1.5, 1e-12);
  EXPECT_NEAR(v.current.z(), 2.5, 1e-12);
  EXPECT_NEAR(v.current[4], 0.4, 1e-12);
}

}  // namespace
}  // namespace cliquevo::vo
