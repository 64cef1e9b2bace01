// SPDX-License-Identifier: BSD-3-Clause
// VO_ODOMETRY: the covariance over the whole way, failures, jumps.
#include "daemon/lcm/odometry_builder.h"

#include <cmath>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/unit/daemon/lcm/made_up_frames.h"

namespace cliquevo::daemon {
namespace {

Matrix6d matrix(const double (&in)[6][6]) {
  Matrix6d out;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) out(r, c) = in[r][c];
  }
  return out;
}

RigidTransform step() {  // of the camera: a turn to the right on the way
  RigidTransform T;
  T.R = so3_exp({0.002, 0.03, -0.001});
  T.t = {0.01, 0.002, 0.1};
  return T;
}

odometry_t sent(OdometryBuilder& builder, const PublishedFrame& frame) {
  odometry_t out{};
  builder.build(frame, true, frame.estimate.stamp_ns + 1, out);
  return out;
}

PublishedFrame failed(const PublishedFrame& valid, std::int64_t steps) {
  PublishedFrame out = frame_at(valid.index + steps, vo::Status::too_few_features, valid.estimate.T_world_camera);
  for (std::int64_t i = 0; i < steps; ++i) out.estimate.T_world_camera = out.estimate.T_world_camera * step();
  out.estimate.prev_stamp_ns = valid.estimate.stamp_ns;
  out.estimate.covariance = Matrix6d::Identity() * 0.01 * static_cast<double>(steps);
  return out;
}

// A perturbation as the covariance of a delta means it, on the left.
RigidTransform perturbed(const RigidTransform& T, const Vector6d& x) {
  RigidTransform out;
  out.R = so3_exp(x.tail<3>()) * T.R;
  out.t = so3_exp(x.tail<3>()) * T.t + x.head<3>();
  return out;
}

TEST(OdometryBuilder, TheCovarianceIsThatOfManyNoisyWays) {
  constexpr int kFrames = 40;
  constexpr int kWays = 4000;
  const RigidTransform T_body_camera = forward_camera();
  Matrix6d noise = Matrix6d::Zero();
  noise.diagonal() << 1e-6, 2e-6, 4e-6, 1e-7, 3e-7, 2e-7;
  OdometryBuilder builder(T_body_camera);
  PublishedFrame frame = frame_at(0, vo::Status::no_data, {});
  odometry_t last = sent(builder, frame);
  for (int i = 0; i < kFrames; ++i) {
    frame = next_valid(frame, step());
    frame.estimate.covariance = noise;
    last = sent(builder, frame);
  }
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Matrix6d sampled = Matrix6d::Zero();
  const RigidTransform true_pose = T_body_camera * frame.estimate.T_world_camera * T_body_camera.inverse();
  // Noise of the image that a motion ends in, which the next takes back; and as much of the motion's own, of which a
  // part fades slowly.
  const double fade = std::exp(-1.0 / kSharedMotions);
  for (int k = 0; k < kWays; ++k) {
    RigidTransform T;
    Vector6d before;
    Vector6d common;
    for (int j = 0; j < 6; ++j) {
      before[j] = 0.0;
      common[j] = std::sqrt(kShared) * normal(random);
    }
    double noise_before = 0.0;
    for (int i = 0; i < kFrames; ++i) {
      const double noise_now = 0.5 * (1.0 - noise_before);
      Vector6d now;
      Vector6d x;
      for (int j = 0; j < 6; ++j) {
        now[j] = normal(random);
        common[j] = fade * common[j] + std::sqrt(kShared * (1.0 - fade * fade)) * normal(random);
        const double own = std::sqrt(1.0 - kShared) * normal(random) + common[j];
        x[j] = std::sqrt(noise(j, j)) * (std::sqrt(noise_now) * (now[j] + own) - std::sqrt(noise_before) * before[j]);
      }
      noise_before = noise_now;
      before = now;
      T = T * perturbed(step(), x);
    }
    const RigidTransform pose = T_body_camera * T * T_body_camera.inverse();
    Vector6d error;
    error << pose.t - true_pose.t, so3_log(pose.R * true_pose.R.transpose());
    sampled += error * error.transpose() / kWays;
  }
  const Matrix6d reported = matrix(last.pose_covariance);
  EXPECT_TRUE(reported.isApprox(reported.transpose()));
  // Along every direction: the generalised eigenvalues are 1 but for the sampling, sqrt(2 / 4000) = 2 %.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> ratio(sampled, reported);
  EXPECT_GT(ratio.eigenvalues().minCoeff(), 0.88);
  EXPECT_LT(ratio.eigenvalues().maxCoeff(), 1.14);
}

TEST(OdometryBuilder, TheCovarianceIsOneHoweverMuchSuccessiveMotionsDiffer) {
  PoseCovariance covariance;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double before = 0.0;
  for (int i = 0; i < 400; ++i) {
    Matrix6d root = Matrix6d::Zero();
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c) root(r, c) = normal(random) * (r == c ? 1.0 : 0.5);
    }
    const double scale = std::pow(10.0, -4.0 * (i % 3) - 4.0);
    const RigidTransform T = step();
    covariance.add(so3_exp({0.0, 0.1 * i, 0.0}), T.t, scale * root * root.transpose(), i % 3 == 0 ? 0.01 : 1.0,
                   i % 17 != 0 ? PoseCovariance::Motion::next : PoseCovariance::Motion::after_gap);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(covariance.matrix());
    EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0) << i;
    if (i % 100 == 99) {
      EXPECT_GT(covariance.matrix().trace(), 1.2 * before) << i;
      before = covariance.matrix().trace();
    }
  }
}

TEST(OdometryBuilder, WhatABlurredPictureAddsIsTakenBackInPart) {
  PoseCovariance sharp;
  PoseCovariance blurred;
  const Matrix6d usual = 1e-6 * Matrix6d::Identity();
  std::vector<double> added;
  for (int i = 0; i < 53; ++i) {
    const bool blur = i == 50 || i == 51;  // both motions that the picture is in
    const Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    const Eigen::Vector3d t = Eigen::Vector3d::Zero();
    sharp.add(R, t, usual, 1.0, PoseCovariance::Motion::next);
    blurred.add(R, t, blur ? 100.0 * usual : usual, 1.0, PoseCovariance::Motion::next);
    added.push_back(blurred.matrix().trace() - sharp.matrix().trace());
  }
  EXPECT_EQ(added[49], 0.0);
  EXPECT_GT(added[50], 95.0 * usual.trace());
  EXPECT_LT(added[52], 0.8 * added[50]);  // of 200 that both motions have
}

TEST(OdometryBuilder, OfANoisyCamerasVarianceLessLasts) {
  EXPECT_EQ(PoseCovariance::lasting_part(0.13), 1.0);
  EXPECT_EQ(PoseCovariance::lasting_part(0.0), 1.0) << "nothing is known of it";
  EXPECT_GT(PoseCovariance::lasting_part(0.145), 0.95);
  EXPECT_LT(PoseCovariance::lasting_part(0.21), 0.55);
  PoseCovariance clean;
  PoseCovariance noisy;
  const Matrix6d usual = 1e-6 * Matrix6d::Identity();
  const Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double before = 0.0;
  for (int i = 0; i < 200; ++i) {
    clean.add(Eigen::Matrix3d::Identity(), t, usual, 1.0, PoseCovariance::Motion::next);
    noisy.add(Eigen::Matrix3d::Identity(), t, usual, 0.4, PoseCovariance::Motion::next);
    if (i % 20 != 19) continue;
    EXPECT_GT(noisy.matrix().trace(), 1.02 * before);
    before = noisy.matrix().trace();
  }
  EXPECT_LT(noisy.matrix().trace(), 0.45 * clean.matrix().trace());
  EXPECT_GT(noisy.matrix().trace(), 0.39 * clean.matrix().trace());
}

TEST(OdometryBuilder, AFailureGrowsTheCovarianceAndAValidFrameSpansIt) {
  OdometryBuilder builder(forward_camera());
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  sent(builder, first);
  const PublishedFrame valid = next_valid(first, step());
  const double before = matrix(sent(builder, valid).pose_covariance).trace();
  double guessed = before;
  for (int i = 1; i <= 5; ++i) {
    const odometry_t guess = sent(builder, failed(valid, i));
    EXPECT_EQ(guess.quality, 0);
    EXPECT_EQ(guess.pose_is_guess, 1);
    EXPECT_EQ(guess.reset_counter, 0);
    const double trace = matrix(guess.pose_covariance).trace();
    EXPECT_GT(trace, guessed);
    guessed = trace;
    EXPECT_GE(guess.twist_covariance[0][0], 1e5);
    EXPECT_LE(guess.twist_covariance[0][0], 1e9);
  }
  // As the guess had it: no jump.
  RigidTransform across;
  for (int i = 0; i < 6; ++i) across = across * step();
  const odometry_t again = sent(builder, next_valid(valid, across, 6));
  EXPECT_EQ(again.pose_is_guess, 0);
  EXPECT_EQ(again.reset_counter, 0);
  EXPECT_EQ(again.prev_utime, valid.estimate.stamp_ns / 1000);
  const double after = matrix(again.pose_covariance).trace();
  EXPECT_GT(after, before);
  EXPECT_LT(after, guessed);
}

TEST(OdometryBuilder, AJumpAndAResetRaiseTheCounter) {
  OdometryBuilder builder(forward_camera());
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  sent(builder, first);
  const PublishedFrame valid = next_valid(first, step());
  sent(builder, valid);
  sent(builder, failed(valid, 1));
  RigidTransform elsewhere = step() * step();
  elsewhere.t.x() += 0.5;
  EXPECT_EQ(sent(builder, next_valid(valid, elsewhere, 2)).reset_counter, 1);
  PublishedFrame anew = frame_at(9, vo::Status::no_data, {});
  anew.resets = 1;
  const odometry_t reset = sent(builder, anew);
  EXPECT_EQ(reset.reset_counter, 2);
  EXPECT_LT(matrix(reset.pose_covariance).trace(), 1e-6);
  EXPECT_GT(Eigen::LLT<Matrix6d>(matrix(reset.pose_covariance)).matrixL().determinant(), 0.0);
}

TEST(OdometryBuilder, TheTwistIsThatOfTheBodyInItsOwnFrame) {
  OdometryBuilder builder(forward_camera());
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  sent(builder, first);
  RigidTransform ahead;
  ahead.t = {0.0, 0.0, 0.1};  // the camera's forward is the body's X
  const odometry_t m = sent(builder, next_valid(first, ahead));
  const double dt_s = static_cast<double>(kPeriodNs) * 1e-9;
  EXPECT_NEAR(m.velocity[0], 0.1 / dt_s, 1e-9);
  EXPECT_NEAR(m.velocity[1], 0.0, 1e-12);
  EXPECT_NEAR(m.rotation_rate[2], 0.0, 1e-12);
  RigidTransform turn;
  turn.R = so3_exp({0.0, 0.01, 0.0});  // to the right: the body's yaw rate is negative
  EXPECT_LT(sent(builder, next_valid(next_valid(first, ahead), turn)).rotation_rate[2], -0.29);
}

TEST(OdometryBuilder, WhatIsNotFiniteIsSentAsAGuessThatSaysNothing) {
  OdometryBuilder builder(forward_camera());
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  sent(builder, first);
  PublishedFrame bad = next_valid(first, step());
  bad.estimate.T_prev_cur.t.x() = std::nan("");
  bad.estimate.covariance *= std::nan("");
  odometry_t out{};
  builder.build(bad, false, bad.estimate.stamp_ns, out);
  EXPECT_TRUE(matrix(out.pose_covariance).allFinite());
  EXPECT_LE(matrix(out.pose_covariance).maxCoeff(), 1e9);
  EXPECT_GE(out.pose_covariance[0][0], 1e5);
  EXPECT_EQ(out.pose_is_guess, 1);
}

}  // namespace
}  // namespace cliquevo::daemon
