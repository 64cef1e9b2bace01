// SPDX-License-Identifier: BSD-3-Clause
// What is learned of a camera's noise, and where the pose goes while nothing is seen.
#include "core/vo/noise.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/vo/dead_reckoning.h"
#include "core/vo/reference_frames.h"
#include "core/vo/surface_patch.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{320, 240, 300.0, 300.0, 159.5, 119.5, 0.2, 0.0};

Motion reading(double shift_px, double information = 150.0) {
  Motion motion;
  motion.free_shift_px = shift_px;
  motion.shift_information = information;
  return motion;
}

TEST(Noise, TheExpectedErrorFollowsTheScatterBetweenLeftAndRight) {
  CameraNoise noise;
  Frame frame{VoParams{}};
  for (const double scatter : {0.06, 0.3}) {
    frame.row_scatter_px = scatter;
    for (int i = 0; i < 400; ++i) noise.add_views(frame);
    EXPECT_NEAR(noise.expected_error_px(), std::hypot(0.13, 1.5 * scatter), 0.01);
  }
}

TEST(Noise, AFrameWithoutMeasurementsTeachesNothing) {
  CameraNoise noise;
  const double before = noise.expected_error_px();
  noise.add_views(Frame{VoParams{}});
  EXPECT_EQ(noise.expected_error_px(), before);
}

TEST(Noise, AStiffRigsShiftIsLearnedToBeNearZero) {
  CameraNoise noise;
  std::mt19937 rng(1);
  std::normal_distribution<double> n(0.0, 0.1);
  for (int i = 0; i < 200; ++i) noise.add_motion(reading(n(rng)));
  EXPECT_LT(noise.shift_sigma_px(), 0.06);
}

TEST(Noise, AFlexingRigsShiftIsLearnedToItsWidth) {
  CameraNoise noise;
  std::mt19937 rng(2);
  std::normal_distribution<double> n(0.0, 1.0);
  for (int i = 0; i < 300; ++i) noise.add_motion(reading(n(rng)));
  EXPECT_NEAR(noise.shift_sigma_px(), 1.0, 0.3);
}

TEST(Noise, OneFrameFarOutsideWidensItsOwnPriorAlone) {
  CameraNoise noise;
  for (int i = 0; i < 100; ++i) noise.add_motion(reading(0.0));
  EXPECT_GT(noise.shift_news(reading(1.5)), 9.0);
  EXPECT_NEAR(noise.shift_sigma_px(reading(1.5)), 1.5, 1e-9);
  EXPECT_LT(noise.shift_sigma_px(), 0.1);
}

TEST(Noise, WithoutInformationAReadingCountsForNothing) {
  CameraNoise noise;
  const double before = noise.shift_sigma_px();
  noise.add_motion(reading(3.0, 0.0));
  noise.add_motion(reading(std::nan("")));
  EXPECT_EQ(noise.shift_sigma_px(), before);
}

TEST(Noise, RowsOfAFrameCountAsFarAsTheyExceedNoise) {
  CameraNoise still, shaking;
  Frame frame{VoParams{}};
  frame.row_scatter_px = 0.1;
  for (int i = 0; i < 200; ++i) {
    frame.row_shift_px = i % 2 == 0 ? 0.02 : -0.02;
    still.add_views(frame);
    frame.row_shift_px = i % 2 == 0 ? 0.5 : -0.5;
    shaking.add_views(frame);
  }
  frame.row_shift_px = 0.5;
  EXPECT_EQ(still.row_shift_px(frame), 0.0);
  EXPECT_NEAR(shaking.row_shift_px(frame), 0.5, 0.01);
}

TEST(Noise, GreyLevelsAreTheMeanOfWhatFramesShow) {
  CameraNoise noise;
  Frame frame{VoParams{}};
  frame.row_scatter_px = 0.1;
  for (const double greys : {2.0, 4.0, 6.0}) {
    frame.grey_scatter = greys;
    noise.add_views(frame);
  }
  EXPECT_NEAR(noise.grey_levels(), 4.0, 1e-9);
}

TEST(DeadReckoning, PredictsTheLastMotionOverAnyTime) {
  DeadReckoning reckoning{VoParams{}};
  EXPECT_FALSE(reckoning.knows_speed());
  EXPECT_EQ(reckoning.prediction(1'000'000'000).t.norm(), 0.0);
  RigidTransform step;
  step.t = {0.0, 0.0, 0.2};
  step.R = so3_exp({0.0, 0.02, 0.0});
  reckoning.learn(step, 100'000'000);
  EXPECT_TRUE(reckoning.knows_speed());
  EXPECT_EQ(reckoning.last_motion().t, step.t);
  const RigidTransform later = reckoning.prediction(250'000'000);
  EXPECT_NEAR(later.t.z(), 0.5, 1e-12);
  EXPECT_NEAR(later.angle(), 0.05, 1e-9);
  reckoning.learn(step, 0);
  reckoning.reset();
  EXPECT_FALSE(reckoning.knows_speed());
}

TEST(DeadReckoning, SmoothesWhatItLearned) {
  DeadReckoning reckoning{VoParams{}};
  RigidTransform step;
  for (int i = 0; i < 60; ++i) {
    step.t = {0.0, 0.0, i % 2 == 0 ? 0.12 : 0.08};
    reckoning.learn(step, 33'333'333);
  }
  Vector6d variance;
  const RigidTransform guess = reckoning.guess(33'333'333, 33'333'333, variance);
  EXPECT_NEAR(guess.t.z(), 0.1, 0.006) << "neither of the last two steps";
  EXPECT_GT(variance.minCoeff(), 0.0);
}

// Speeds up all the time: what was a while ago is always too slow.
TEST(DeadReckoning, GoesOnAsTheLastFrameWhereThatPredictsBest) {
  DeadReckoning reckoning{VoParams{}};
  RigidTransform step;
  for (int i = 0; i < 90; ++i) {
    step.t = {0.0, 0.0, 0.002 * i};
    step.R = so3_exp({0.0, 0.0005 * i, 0.0});
    reckoning.learn(step, 33'333'333);
  }
  Vector6d variance;
  const RigidTransform guess = reckoning.guess(33'333'333, 33'333'333, variance);
  EXPECT_NEAR(guess.t.z(), 0.178, 0.001);
  EXPECT_NEAR(guess.angle(), 0.0445, 0.0002);
}

TEST(DeadReckoning, TurnsNoMoreWhereTurningIsNoiseAlone) {
  DeadReckoning reckoning{VoParams{}};
  RigidTransform step;
  step.t.z() = 0.1;
  for (int i = 0; i < 90; ++i) {
    step.R = so3_exp({0.0, i % 4 < 2 ? 0.01 : -0.01, 0.0});
    reckoning.learn(step, 100'000'000);
  }
  Vector6d variance;
  const RigidTransform guess = reckoning.guess(100'000'000, 100'000'000, variance);
  EXPECT_EQ(guess.angle(), 0.0);
  EXPECT_NEAR(guess.t.z(), 0.1, 1e-4);
}

TEST(DeadReckoning, FadesWhileNothingConfirmsIt) {
  DeadReckoning reckoning{VoParams{}};
  RigidTransform step;
  step.t.z() = 0.1;
  step.R = so3_exp({0.0, 0.02, 0.0});
  for (int i = 0; i < 30; ++i) reckoning.learn(step, 33'333'333);
  Vector6d variance;
  const RigidTransform soon = reckoning.guess(33'333'333, 33'333'333, variance);
  const RigidTransform late = reckoning.guess(33'333'333, 9'000'000'000, variance);
  EXPECT_NEAR(late.t.z() / soon.t.z(), std::exp(-(9.0 * 9.0) / 400.0), 0.01);
  EXPECT_NEAR(late.angle() / soon.angle(), std::exp(-81.0 / 4.0), 1e-6) << "turns end sooner than driving does";
}

TEST(DeadReckoning, HoldsThePoseWhereConfigured) {
  VoParams params;
  params.after_failure = AfterFailure::hold;
  DeadReckoning reckoning{params};
  RigidTransform step;
  step.t.z() = 0.1;
  reckoning.learn(step, 33'333'333);
  Vector6d variance;
  EXPECT_EQ(reckoning.guess(33'333'333, 33'333'333, variance).t.norm(), 0.0);
}

TEST(DeadReckoning, AGapBeforeAnySpeedWasKnownIsCrossedAsTheMotionAfterItMoves) {
  constexpr TimestampNs kFrame_ns = 33'333'333;
  DeadReckoning reckoning{VoParams{}};
  RigidTransform after;
  after.t.z() = 0.1;
  after.R = so3_exp({0.0, 0.01, 0.0});
  const RigidTransform crossed = reckoning.across({}, 2 * kFrame_ns, after, kFrame_ns);
  EXPECT_NEAR(crossed.t.z(), 0.2, 0.001);
  EXPECT_NEAR(crossed.angle(), 0.02, 0.0005);
  reckoning.learn(after, kFrame_ns);
  RigidTransform guessed;
  guessed.t.z() = 0.15;
  EXPECT_EQ(reckoning.across(guessed, 2 * kFrame_ns, after, kFrame_ns).t.z(), 0.15) << "a speed was known";
}

TEST(ReferenceFrames, KeepThreeFramesOfTheWayAndAlwaysHaveASpareOne) {
  ReferenceFrames frames(kModel, {});
  std::vector<Frame*> keys;
  for (int i = 0; i < 12; ++i) {
    Frame* current = frames.spare();
    ASSERT_NE(current, nullptr) << i;
    if (i % 3 == 2) {
      frames.refuse(current);
      continue;
    }
    frames.accept(current, Matrix6d::Identity(), true);
    keys.push_back(current);
  }
  const std::size_t n = keys.size();
  EXPECT_EQ(frames.key(), keys[n - 1]);
  for (std::size_t k = 0; k < ReferenceFrames::kOlder; ++k) EXPECT_EQ(frames.older()[k], keys[n - 2 - k]);
  EXPECT_EQ(frames.covariance_to_valid(*frames.valid())(0, 0), 0.0);
  EXPECT_EQ(frames.covariance_to_valid(*frames.older()[0])(0, 0), 1.0);
  EXPECT_EQ(frames.covariance_to_valid(*frames.older()[2])(0, 0), 3.0);
}

TEST(ReferenceFrames, AFrameThatHasNoOtherRoleIsFreeAgain) {
  ReferenceFrames frames(kModel, {});
  Frame* const first = frames.spare();
  frames.accept(first, Matrix6d::Identity(), true);
  Frame* const second = frames.spare();
  EXPECT_NE(second, first) << "it is the valid one and the key frame";
  frames.refuse(second);
  EXPECT_EQ(&frames.last(), second);
  EXPECT_EQ(frames.failed(), second);
  Frame* const third = frames.spare();
  frames.accept(third, Matrix6d::Identity(), false);
  EXPECT_EQ(frames.failed(), nullptr);
  EXPECT_EQ(&frames.last(), third);
  EXPECT_EQ(frames.key(), first);
  EXPECT_EQ(frames.covariance_to_valid(*first)(0, 0), 1.0) << "the valid one is known to this, seen from the key frame";
  frames.clear();
  EXPECT_EQ(frames.valid(), nullptr);
  EXPECT_EQ(frames.key(), nullptr);
}

TEST(SurfacePatch, BetweenRowsOfARollingShutterLiesItsShareOfTheWay) {
  StereoModel rolling = kModel;
  rolling.readout_s = 0.02;
  const RollingShutter shutter(rolling);
  Feature f;
  f.x = 160;
  f.y = 120;
  f.disparity_px = 20.0;  // at 3 m
  RigidTransform T_cur_ref;
  T_cur_ref.t.y() = -0.5;  // up by 50 px there: a quarter of the picture later
  Velocity velocity = Velocity::Zero();
  velocity[0] = 1.0;  // m/s to the right
  const RigidTransform T = between_rows(rolling, shutter, f, f.disparity_px, T_cur_ref, Velocity::Zero(), velocity);
  // The row 50 px higher is exposed earlier by its share of the readout: the camera is still further left.
  EXPECT_NEAR(T.t.x(), 0.02 * 50.0 / 240.0, 1e-4);
  EXPECT_NEAR(T.t.y(), -0.5, 1e-4);
  EXPECT_NEAR(velocity_of(T_cur_ref, 500'000'000)[1], -1.0, 1e-9);
  EXPECT_TRUE(shutter.rolls());
  EXPECT_FALSE(RollingShutter(kModel).rolls());
}

TEST(SurfacePatch, OfAFrontalWallSeenFromNearerIsLarger) {
  Feature f;
  f.x = 100;
  f.y = 80;
  f.disparity_px = 20.0;  // at 3 m
  RigidTransform T_cur_ref;
  T_cur_ref.t.z() = -1.0;
  SurfacePatch seen;
  ASSERT_TRUE(surface_patch(kModel, f, f.disparity_px, T_cur_ref, 3.0, seen));
  EXPECT_NEAR(seen.disparity_px, 30.0, 1e-9);
  EXPECT_NEAR(seen.area, 1.5 * 1.5, 1e-6);
  EXPECT_NEAR(seen.u, 159.5 + 1.5 * (100 - 159.5), 1e-9);
  EXPECT_NEAR(seen.to_right.xx, 1.0, 1e-6);
  T_cur_ref.t.z() = -4.0;
  EXPECT_FALSE(surface_patch(kModel, f, f.disparity_px, T_cur_ref, 3.0, seen)) << "behind the camera";
}

}  // namespace
}  // namespace cliquevo::vo
