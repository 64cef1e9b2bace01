// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::tools {
namespace {

using daemon::Trajectory;
using daemon::TrajectoryFormat;

constexpr double kDegree = 57.29577951308232;

// Straight on, `count` poses `step_m` apart.
Trajectory straight(std::size_t count, double step_m, TrajectoryFormat format = TrajectoryFormat::kitti) {
  Trajectory out;
  out.format = format;
  for (std::size_t i = 0; i < count; ++i) {
    RigidTransform T;
    T.t.z() = step_m * static_cast<double>(i);
    out.poses.push_back({format == TrajectoryFormat::tum ? static_cast<TimestampNs>(i) * 100'000'000 : 0, T});
  }
  return out;
}

Trajectory winding(std::size_t count, TrajectoryFormat format) {
  Trajectory out;
  out.format = format;
  RigidTransform T;
  for (std::size_t i = 0; i < count; ++i) {
    out.poses.push_back({static_cast<TimestampNs>(i) * 50'000'000, T});
    const double s = static_cast<double>(i);
    T = T * perturb_left(
                {}, (Vector6d() << 0.02, 0.01 * std::sin(s), 0.3, 0.01, 0.05 * std::sin(0.1 * s), 0.02).finished());
  }
  return out;
}

Evaluation compare(const Trajectory& reference, const Trajectory& estimate, const EvaluationOptions& options = {}) {
  const auto pairs = associate(reference, estimate, options);
  EXPECT_TRUE(pairs.ok()) << pairs.error().line();
  return evaluate(*pairs, options);
}

TEST(Evaluation, ATrajectoryAgainstItselfHasNoError) {
  const Trajectory t = winding(400, TrajectoryFormat::tum);
  const Evaluation e = compare(t, t);
  EXPECT_EQ(e.frames_compared, 400u);
  EXPECT_NEAR(*e.t_err_pct, 0.0, 1e-10);
  EXPECT_NEAR(e.ate_m, 0.0, 1e-9);
  EXPECT_NEAR(e.rpe_m, 0.0, 1e-12);
  EXPECT_NEAR(e.end_m, 0.0, 1e-12);
  EXPECT_NEAR(e.path_m, e.path_estimate_m, 1e-9);
}

TEST(Evaluation, AScaleErrorIsTheSegmentErrorInPercent) {
  // 0.5 m steps, 2 % too long: a segment of 10 m ends at the first frame beyond 10 m, 10.5 m on.
  EvaluationOptions options;
  options.lengths_m = {10};
  const Evaluation e = compare(straight(101, 0.5), straight(101, 0.51), options);
  EXPECT_EQ(e.segments, 101 - 21);
  EXPECT_NEAR(*e.t_err_pct, 100 * 10.5 * 0.02 / 10, 1e-9);
  EXPECT_NEAR(*e.r_err_deg_m, 0.0, 1e-9);
  EXPECT_NEAR(e.rpe_m, 0.01, 1e-12);
  EXPECT_NEAR(*e.end_pct, 2.0, 1e-9);
  EXPECT_NEAR(e.end_m, 1.0, 1e-9);
}

TEST(Evaluation, AConstantTurnIsTheRotationErrorPerMetre) {
  Trajectory turned = straight(61, 1.0);
  RigidTransform T;
  const RigidTransform step = perturb_left({}, (Vector6d() << 0, 0, 1.0, 0, 0.001, 0).finished());
  for (auto& pose : turned.poses) {
    pose.T_world_camera = T;
    T = T * step;
  }
  EvaluationOptions options;
  options.lengths_m = {10, 20};
  const Evaluation e = compare(straight(61, 1.0), turned, options);
  // Segments are 11 and 21 steps long.
  EXPECT_NEAR(e.by_length[0].r_err_deg_m, 11 * 0.001 / 10 * kDegree, 1e-6);
  EXPECT_NEAR(e.by_length[1].r_err_deg_m, 21 * 0.001 / 20 * kDegree, 1e-6);
  EXPECT_EQ(e.by_length[0].segments, 50);
  EXPECT_EQ(e.by_length[1].segments, 40);
  EXPECT_NEAR(e.rpe_deg, 0.001 * kDegree, 1e-9);
}

TEST(Evaluation, LengthsBeyondThePathAreLeftOut) {
  EvaluationOptions options;
  options.lengths_m = {100};
  const Evaluation e = compare(straight(11, 1.0), straight(11, 1.0), options);
  EXPECT_EQ(e.segments, 0);
  EXPECT_FALSE(e.t_err_pct.has_value());
  EXPECT_FALSE(e.r_err_deg_m.has_value());
}

TEST(Evaluation, AteForgetsARigidMotionButNotAScale) {
  const Trajectory reference = winding(300, TrajectoryFormat::tum);
  Trajectory moved = reference;
  const RigidTransform M = perturb_left({}, (Vector6d() << 5, -3, 2, 1.0, -0.7, 2.0).finished());
  for (auto& pose : moved.poses) pose.T_world_camera = M * pose.T_world_camera;
  EXPECT_NEAR(compare(reference, moved).ate_m, 0.0, 1e-9);
  for (auto& pose : moved.poses) pose.T_world_camera.t *= 1.1;
  EXPECT_GT(compare(reference, moved).ate_m, 0.1);
}

TEST(Evaluation, AteIsTheRootMeanSquareOfWhatAlignmentLeaves) {
  // Corners of a square pushed outwards one by one and inwards the next: no rigid motion helps.
  Trajectory reference;
  Trajectory estimate;
  reference.format = estimate.format = TrajectoryFormat::tum;
  const double push = 0.1;
  for (int i = 0; i < 4; ++i) {
    const double angle = i * std::acos(-1.0) / 2;
    RigidTransform T;
    T.t = {std::cos(angle), std::sin(angle), 0};
    reference.poses.push_back({i * 1'000'000'000LL, T});
    T.t *= i % 2 == 0 ? 1 + push : 1 - push;
    estimate.poses.push_back({i * 1'000'000'000LL, T});
  }
  const Evaluation e = compare(reference, estimate);
  EXPECT_NEAR(e.ate_m, push, 1e-9);
  EXPECT_NEAR(e.ate_max_m, push, 1e-9);
}

TEST(Evaluation, StandingStillIsNoDivisionByZero) {
  const Evaluation e = compare(straight(20, 0.0), straight(20, 0.0));
  EXPECT_FALSE(e.end_pct.has_value());
  EXPECT_FALSE(e.t_err_pct.has_value());
  EXPECT_EQ(e.ate_m, 0.0);
  EXPECT_TRUE(e.T_reference_estimate.is_finite());
}

TEST(Evaluation, StampsAreAssociatedWithTheNearestWithinTenMilliseconds) {
  const Trajectory reference = straight(20, 1.0, TrajectoryFormat::tum);
  Trajectory estimate = reference;
  for (auto& pose : estimate.poses) pose.stamp_ns += 9'000'000;
  estimate.poses[3].stamp_ns += 2'000'000;  // 11 ms
  const auto pairs = associate(reference, estimate, {});
  ASSERT_TRUE(pairs.ok());
  ASSERT_EQ(pairs->size(), 19u);
  EXPECT_EQ((*pairs)[3].estimate_index, 4u);
  EXPECT_EQ((*pairs)[3].reference.t.z(), 4.0);
}

TEST(Evaluation, AReferencePoseServesOnlyTheNearestEstimate) {
  const Trajectory reference = straight(3, 1.0, TrajectoryFormat::tum);
  Trajectory estimate;
  estimate.format = TrajectoryFormat::tum;
  for (const TimestampNs stamp_ms : {-8, -2, 5, 95, 101, 200}) estimate.poses.push_back({stamp_ms * 1'000'000, {}});
  const auto pairs = associate(reference, estimate, {});
  ASSERT_TRUE(pairs.ok());
  ASSERT_EQ(pairs->size(), 3u);
  EXPECT_EQ((*pairs)[0].estimate_index, 1u);
  EXPECT_EQ((*pairs)[1].estimate_index, 4u);
  EXPECT_EQ((*pairs)[2].estimate_index, 5u);
}

TEST(Evaluation, KittiFilesOfUnequalLengthAreComparedAsFarAsTheShorterGoes) {
  const Evaluation e = compare(straight(51, 1.0), straight(31, 1.0));
  EXPECT_EQ(e.frames_compared, 31u);
  EXPECT_NEAR(e.path_m, 30.0, 1e-9);
}

TEST(Evaluation, MixedFormatsAndStrangersAreErrors) {
  EXPECT_FALSE(associate(straight(5, 1.0), straight(5, 1.0, TrajectoryFormat::tum), {}).ok());
  Trajectory later = straight(5, 1.0, TrajectoryFormat::tum);
  for (auto& pose : later.poses) pose.stamp_ns += 1'000'000'000'000;
  EXPECT_FALSE(associate(straight(5, 1.0, TrajectoryFormat::tum), later, {}).ok());
}

TEST(Evaluation, AReferenceInBodyAxesIsTurnedIntoCameraAxes) {
  const Trajectory camera = winding(200, TrajectoryFormat::tum);
  RigidTransform T_body_camera;  // X forward, Y left, Z up
  T_body_camera.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Trajectory body = camera;
  for (auto& pose : body.poses) {
    pose.T_world_camera = T_body_camera * pose.T_world_camera * T_body_camera.inverse();
  }
  EvaluationOptions options;
  EXPECT_GT(*compare(body, camera, options).t_err_pct, 10.0);
  EXPECT_NEAR(compare(body, camera, options).ate_m, 0.0, 1e-9);
  options.reference_frame = ReferenceFrame::body;
  EXPECT_NEAR(*compare(body, camera, options).t_err_pct, 0.0, 1e-9);
}

TEST(Evaluation, ASampledPathDoesNotCountTheJitterBetweenTheSamples) {
  Trajectory jittery = straight(101, 0.01, TrajectoryFormat::tum);
  for (std::size_t i = 0; i < jittery.poses.size(); ++i) jittery.poses[i].T_world_camera.t.x() = i % 2 == 0 ? 0 : 0.01;
  EvaluationOptions options;
  options.sample_period_s = 0.2;  // every second pose
  const Evaluation e = compare(straight(101, 0.01, TrajectoryFormat::tum), jittery, options);
  EXPECT_GT(e.path_estimate_m, 1.4);
  EXPECT_NEAR(*e.sampled_path_estimate_m, 1.0, 1e-9);
  EXPECT_NEAR(*e.sampled_path_m, 1.0, 1e-9);
}

}  // namespace
}  // namespace cliquevo::tools
