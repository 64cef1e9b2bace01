// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/messages.h"

#include <bot_core/pose_t.hpp>
#include <cmath>
#include <fovis/update_t.hpp>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/daemon/lcm/made_up_frames.h"

namespace cliquevo::daemon {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A step forward and a small turn to the left, as seen by the camera.
RigidTransform forward_and_left() {
  RigidTransform T;
  T.R = so3_exp({0.0, -0.02, 0.0});
  T.t = {0.01, 0.02, 0.1};
  return T;
}

Eigen::Vector3d vec(const double (&v)[3]) { return {v[0], v[1], v[2]}; }
Eigen::Quaterniond quat(const double (&q)[4]) { return {q[0], q[1], q[2], q[3]}; }

bool all_finite(const FrameMessages& m) {
  const auto finite = [](const double* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (!std::isfinite(values[i])) return false;
    }
    return true;
  };
  return finite(m.delta.translation, 3) && finite(m.delta.rotation, 4) && finite(&m.delta.covariance[0][0], 36) &&
         finite(m.delta_body.translation, 3) && finite(m.delta_body.rotation, 4) &&
         finite(&m.delta_body.covariance[0][0], 36) && finite(m.pose.pos, 3) && finite(m.pose.vel, 3) &&
         finite(m.pose.orientation, 4) && finite(m.pose.rotation_rate, 3) && finite(m.pose.accel, 3) &&
         std::isfinite(m.status.reprojection_error_px) && std::isfinite(m.status.eigenvalue_ratio);
}

template <typename Theirs, typename Ours>
Theirs decode_as(const Ours& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())), static_cast<int>(bytes.size()));
  Theirs theirs{};
  EXPECT_EQ(theirs.decode(bytes.data(), 0, static_cast<int>(bytes.size())), static_cast<int>(bytes.size()));
  return theirs;
}

TEST(Messages, FingerprintsEqualThoseOfTheOriginalTypes) {
  EXPECT_EQ(update_t::getHash(), fovis::update_t::getHash());
  EXPECT_EQ(pose_t::getHash(), bot_core::pose_t::getHash());
}

TEST(Messages, EveryFieldOfAMotionIsReadByTheOriginalTypes) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  const PublishedFrame frame = next_valid(first, forward_and_left());
  builder.build(frame, 0, sent);

  const auto delta = decode_as<fovis::update_t>(sent.delta);
  EXPECT_EQ(delta.timestamp, floor_us(frame.estimate.stamp_ns));
  EXPECT_EQ(delta.prev_timestamp, floor_us(first.estimate.stamp_ns));
  EXPECT_EQ(delta.estimate_status, 1);
  EXPECT_EQ(vec(delta.translation), frame.estimate.T_prev_cur.t);
  EXPECT_NEAR((quat(delta.rotation).toRotationMatrix() - frame.estimate.T_prev_cur.R).norm(), 0.0, 1e-14);
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) EXPECT_EQ(delta.covariance[r][c], frame.estimate.covariance(r, c)) << r << ' ' << c;
  }

  const auto pose = decode_as<bot_core::pose_t>(sent.pose);
  EXPECT_EQ(pose.utime, delta.timestamp);
  EXPECT_EQ(vec(pose.pos), vec(sent.pose.pos));
  EXPECT_EQ(vec(pose.vel), vec(sent.pose.vel));
  EXPECT_EQ(quat(pose.orientation).coeffs(), quat(sent.pose.orientation).coeffs());
  EXPECT_EQ(vec(pose.rotation_rate), vec(sent.pose.rotation_rate));
  EXPECT_EQ(vec(pose.accel), Eigen::Vector3d(0, 0, 0));
}

TEST(Messages, TheWorldIsTheBodyAtStart) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  builder.build(frame_at(0, vo::Status::no_data, {}), 0, sent);
  EXPECT_NEAR(vec(sent.pose.pos).norm(), 0.0, 1e-15);
  EXPECT_NEAR(quat(sent.pose.orientation).w(), 1.0, 1e-15);
  EXPECT_EQ(vec(sent.pose.vel), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(vec(sent.pose.rotation_rate), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(sent.status.pose_is_guess, 0);
}

TEST(Messages, ACameraMovingForwardIsABodyMovingAlongItsXAxis) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  RigidTransform forward;
  forward.t = {0.0, 0.0, 0.1};
  builder.build(next_valid(first, forward), 0, sent);
  EXPECT_NEAR((vec(sent.pose.pos) - Eigen::Vector3d(0.1, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((vec(sent.pose.vel) - Eigen::Vector3d(0.1 / (kPeriodNs * 1e-9), 0.0, 0.0)).norm(), 0.0, 1e-9);
}

TEST(Messages, ATurnOnTheSpotMovesTheMountedCameraButNotTheBody) {
  const RigidTransform T_body_camera = forward_camera();
  RigidTransform turn;  // to the left, about the body's own z axis
  turn.R = so3_exp({0.0, 0.0, 0.05});
  MessageBuilder builder(T_body_camera);
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  PublishedFrame frame = first;
  for (int i = 0; i < 3; ++i) {
    frame = next_valid(frame, T_body_camera.inverse() * turn * T_body_camera);
    builder.build(frame, 0, sent);
  }
  EXPECT_NEAR(vec(sent.pose.pos).norm(), 0.0, 1e-12);
  EXPECT_NEAR(vec(sent.pose.vel).norm(), 0.0, 1e-9);
  EXPECT_NEAR((vec(sent.pose.rotation_rate) - Eigen::Vector3d(0, 0, 0.05 / (kPeriodNs * 1e-9))).norm(), 0.0, 1e-9);
}

TEST(Messages, VelocitiesAreInTheWorldFrameAlsoAfterTheBodyHasTurned) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  PublishedFrame frame = frame_at(0, vo::Status::no_data, {});
  frame.estimate.T_world_camera.R = so3_exp({0.0, -M_PI / 2, 0.0});  // has turned left by a right angle
  builder.build(frame, 0, sent);
  RigidTransform forward;
  forward.t = {0.0, 0.0, 0.1};
  builder.build(next_valid(frame, forward), 0, sent);
  EXPECT_NEAR((vec(sent.pose.vel) - Eigen::Vector3d(0.0, 0.1 / (kPeriodNs * 1e-9), 0.0)).norm(), 0.0, 1e-9);
}

TEST(Messages, TheBodysDeltaIsTheCamerasTurnedAndItsCovarianceWithIt) {
  const RigidTransform T_body_camera = forward_camera();
  MessageBuilder builder(T_body_camera);
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  const PublishedFrame frame = next_valid(first, forward_and_left());
  builder.build(frame, 0, sent);
  // The body started at the world's origin: its delta is its pose.
  EXPECT_NEAR((vec(sent.delta_body.translation) - vec(sent.pose.pos)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((quat(sent.delta_body.rotation).coeffs() - quat(sent.pose.orientation).coeffs()).norm(), 0.0, 1e-12);
  EXPECT_EQ(sent.delta_body.timestamp, sent.delta.timestamp);
  EXPECT_EQ(sent.delta_body.prev_timestamp, sent.delta.prev_timestamp);

  // Against differences: how the body's delta moves when the camera's is perturbed.
  Matrix6d J;
  const auto body_delta = [&](const RigidTransform& T) { return T_body_camera * T * T_body_camera.inverse(); };
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vector6d x = Vector6d::Zero();
    x[i] = kStep;
    J.col(i) =
        left_difference(body_delta(frame.estimate.T_prev_cur), body_delta(perturb_left(frame.estimate.T_prev_cur, x))) /
        kStep;
  }
  const Matrix6d expected = J * frame.estimate.covariance * J.transpose();
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) EXPECT_NEAR(sent.delta_body.covariance[r][c], expected(r, c), 1e-9) << r << ' ' << c;
  }
}

TEST(Messages, AFailedFrameSendsTheIdentityAndAPoseThatIsMarkedAsAGuess) {
  MessageBuilder builder(forward_camera());
  for (const vo::Status status :
       {vo::Status::too_few_features, vo::Status::degenerate, vo::Status::reprojection_error, vo::Status::ambiguous}) {
    FrameMessages sent;
    PublishedFrame frame = frame_at(4, status, forward_and_left());
    frame.estimate.prev_stamp_ns = kFirstStampNs;
    frame.estimate.T_prev_cur = forward_and_left();
    builder.build(frame, 0, sent);
    EXPECT_EQ(vec(sent.delta.translation), Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(quat(sent.delta.rotation).w(), 1.0);
    EXPECT_NE(sent.delta.estimate_status, update_t::ESTIMATE_VALID);
    EXPECT_EQ(sent.status.status, static_cast<std::int8_t>(status));
    EXPECT_EQ(sent.status.pose_is_guess, 1);
    EXPECT_GT(vec(sent.pose.pos).norm(), 0.0);
  }
}

TEST(Messages, AnAmbiguousFrameIsDegenerateToReadersOfTheOldType) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  builder.build(frame_at(1, vo::Status::ambiguous, {}), 0, sent);
  EXPECT_EQ(sent.delta.estimate_status, update_t::ESTIMATE_DEGENERATE);
  EXPECT_EQ(sent.status.status, status_t::AMBIGUOUS);
}

TEST(Messages, TheStatusSaysWhyAFrameFailed) {
  MessageBuilder builder({});
  FrameMessages sent;
  builder.build(frame_at(0, vo::Status::no_data, {}), 0, sent);
  PublishedFrame frame = frame_at(1, vo::Status::weak, {});
  frame.estimate.checks[vo::Check::inliers] = {0.1, 1.0, true};
  frame.estimate.checks[vo::Check::uncertainty] = {3.0, 1.5, true};
  frame.estimate.checks[vo::Check::spread] = {std::nan(""), 1.0, true};
  frame.estimate.quality = 20;
  builder.build(frame, 0, sent);
  EXPECT_EQ(sent.status.status, status_t::WEAK);
  EXPECT_EQ(sent.delta.estimate_status, update_t::ESTIMATE_DEGENERATE) << "readers of fovis' type know 0 to 4";
  EXPECT_EQ(sent.status.quality, 20);
  ASSERT_EQ(sent.status.n_checks, static_cast<int>(vo::kChecks));
  EXPECT_EQ(sent.status.check_ratio[status_t::CHECK_INLIERS], 0.1);
  EXPECT_EQ(sent.status.check_ratio[status_t::CHECK_UNCERTAINTY], 2.0);
  EXPECT_TRUE(std::isfinite(sent.status.check_ratio[status_t::CHECK_SPREAD]));
  EXPECT_EQ(sent.status.checks_failed, 1 << status_t::CHECK_UNCERTAINTY | 1 << status_t::CHECK_SPREAD);
}

TEST(Messages, TheMotionAfterAGapStartsAtTheLastValidFrame) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  PublishedFrame failed = frame_at(1, vo::Status::too_few_features, {});
  failed.estimate.T_world_camera.t = {0.0, 0.0, 5.0};  // a bad guess
  failed.estimate.prev_stamp_ns = first.estimate.stamp_ns;
  builder.build(failed, 0, sent);
  EXPECT_EQ(sent.delta.prev_timestamp, floor_us(first.estimate.stamp_ns));
  RigidTransform forward;
  forward.t = {0.0, 0.0, 0.3};
  const PublishedFrame frame = next_valid(first, forward, 3);
  builder.build(frame, 0, sent);
  EXPECT_EQ(sent.delta.prev_timestamp, floor_us(first.estimate.stamp_ns));
  EXPECT_EQ(sent.delta.timestamp, floor_us(frame.estimate.stamp_ns));
  // The mean speed over the gap, not the leap back from the guess.
  EXPECT_NEAR(sent.pose.vel[0], 0.1 / (kPeriodNs * 1e-9), 1e-9);
}

TEST(Messages, AGuessKeepsTheSpeedThatItWasMadeWith) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
  builder.build(first, 0, sent);
  PublishedFrame guess = frame_at(1, vo::Status::degenerate, {});
  guess.estimate.T_world_camera.t = {0.0, 0.0, 0.2};
  builder.build(guess, 0, sent);
  EXPECT_NEAR(sent.pose.vel[0], 0.2 / (kPeriodNs * 1e-9), 1e-9);
}

TEST(Messages, AResetLeavesNoSpeedFromBefore) {
  MessageBuilder builder(forward_camera());
  FrameMessages sent;
  PublishedFrame before = frame_at(0, vo::Status::no_data, {});
  before.estimate.T_world_camera.t = {0.0, 0.0, 50.0};
  builder.build(before, 0, sent);
  PublishedFrame after = frame_at(1, vo::Status::no_data, {});
  after.resets = 1;
  builder.build(after, 0, sent);
  EXPECT_EQ(vec(sent.pose.vel), Eigen::Vector3d(0, 0, 0));
  PublishedFrame failed = frame_at(1, vo::Status::degenerate, {});
  failed.resets = 2;
  builder.build(failed, 0, sent);
  EXPECT_EQ(vec(sent.pose.vel), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(sent.status.resets, 2);
}

TEST(Messages, NoNumberThatIsNotFiniteEverGoesOut) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double poison : {kNan, inf, -inf}) {
    for (int place = 0; place < 8; ++place) {
      MessageBuilder builder(forward_camera());
      FrameMessages sent;
      const PublishedFrame first = frame_at(0, vo::Status::no_data, {});
      builder.build(first, 0, sent);
      PublishedFrame frame = next_valid(first, forward_and_left());
      if (place == 0) frame.estimate.T_prev_cur.t.y() = poison;
      if (place == 1) frame.estimate.T_prev_cur.R(1, 2) = poison;
      if (place == 2) frame.estimate.covariance(3, 4) = poison;
      if (place == 3) frame.estimate.T_world_camera.t.x() = poison;
      if (place == 4) frame.estimate.T_world_camera.R(0, 0) = poison;
      if (place == 5) frame.estimate.reprojection_error_px = poison;
      if (place == 6) frame.estimate.eigenvalue_ratio = poison;
      if (place == 7) frame.estimate.T_prev_cur.R.setZero();  // finite, but no rotation
      builder.build(frame, 0, sent);
      EXPECT_TRUE(all_finite(sent)) << place;
      EXPECT_EQ(sent.status.repaired, 1) << place;
      const bool motion_hit = place < 5 || place == 7;
      EXPECT_EQ(sent.delta.estimate_status == update_t::ESTIMATE_VALID, !motion_hit) << place;
      EXPECT_EQ(sent.status.pose_is_guess, motion_hit ? 1 : 0) << place;
      EXPECT_NEAR(quat(sent.delta.rotation).norm(), 1.0, 1e-12) << place;
      EXPECT_NEAR(quat(sent.pose.orientation).norm(), 1.0, 1e-12) << place;
      // The next good frame is sent as it is.
      builder.build(next_valid(first, forward_and_left(), 2), 0, sent);
      EXPECT_EQ(sent.status.repaired, 0) << place;
      EXPECT_EQ(sent.delta.estimate_status, update_t::ESTIMATE_VALID) << place;
    }
  }
}

TEST(Messages, MicrosecondsAreRoundedDownOnBothSidesOfZero) {
  EXPECT_EQ(floor_us(1'999), 1);
  EXPECT_EQ(floor_us(1'000), 1);
  EXPECT_EQ(floor_us(999), 0);
  EXPECT_EQ(floor_us(0), 0);
  EXPECT_EQ(floor_us(-1), -1);
  EXPECT_EQ(floor_us(-1'000), -1);
  EXPECT_EQ(floor_us(-1'001), -2);
  EXPECT_EQ(floor_us(std::numeric_limits<std::int64_t>::min()), -9'223'372'036'854'776);
}

TEST(Messages, TheStatusCarriesCountsTimesAndStamps) {
  MessageBuilder builder(forward_camera());
  PublishedFrame frame = next_valid(frame_at(6, vo::Status::no_data, {}), forward_and_left());
  vo::Estimate& e = frame.estimate;
  e.features = 400;
  e.matches = 200;
  e.clique = 120;
  e.inliers = 110;
  e.reprojection_error_px = 0.25;
  e.eigenvalue_ratio = 0.5;
  e.times.features_ns = 1'000'000;
  e.times.scores_ns = 2'000'000;
  e.times.matches_ns = 3'000'000;
  e.times.clique_ns = 4'000'999;
  e.times.motion_ns = 5'000'000;
  frame.times.rectify_ns = 600'000;
  frame.times.stereo_ns = 7'000'000;
  frame.times.odometry_ns = 15'500'000;
  frame.stamps = {10'000'000, 11'000'000, 12'000'000, 13'000'000, 14'000'000};
  frame.dropped = 9;
  frame.resets = 2;
  FrameMessages sent;
  builder.build(frame, 99'999'999, sent);
  const auto s = decode_as<status_t>(sent.status);
  EXPECT_EQ(s.utime, sent.delta.timestamp);
  EXPECT_EQ(s.publish_utime, 99'999);
  EXPECT_EQ(s.frame, 7);
  EXPECT_EQ(s.status, status_t::VALID);
  EXPECT_EQ(s.pose_is_guess, 0);
  EXPECT_EQ(s.repaired, 0);
  EXPECT_EQ(s.features, 400);
  EXPECT_EQ(s.matches, 200);
  EXPECT_EQ(s.clique, 120);
  EXPECT_EQ(s.inliers, 110);
  EXPECT_EQ(s.reprojection_error_px, 0.25);
  EXPECT_EQ(s.eigenvalue_ratio, 0.5);
  EXPECT_EQ(s.rectify_us, 600);
  EXPECT_EQ(s.stereo_us, 7000);
  EXPECT_EQ(s.odometry_us, 15500);
  EXPECT_EQ(s.features_us, 1000);
  EXPECT_EQ(s.scores_us, 2000);
  EXPECT_EQ(s.matches_us, 3000);
  EXPECT_EQ(s.clique_us, 4000);
  EXPECT_EQ(s.motion_us, 5000);
  EXPECT_EQ(s.grabbed_utime, 10'000);
  EXPECT_EQ(s.stereo_begin_utime, 11'000);
  EXPECT_EQ(s.stereo_end_utime, 12'000);
  EXPECT_EQ(s.odometry_begin_utime, 13'000);
  EXPECT_EQ(s.odometry_end_utime, 14'000);
  EXPECT_EQ(s.dropped, 9);
  EXPECT_EQ(s.resets, 2);
}

}  // namespace
}  // namespace cliquevo::daemon
