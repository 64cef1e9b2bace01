// SPDX-License-Identifier: BSD-3-Clause
// Each check beside its bound, from made observations; and the verdict that follows.
#include "core/vo/checks.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/uncertainty.h"
#include "core/vo/verdict.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{320, 240, 300.0, 300.0, 159.5, 119.5, 0.2, 0.0};

// Inliers on a grid, seen again where they were.
struct Seen {
  explicit Seen(int count = 40) : references(1), observations(static_cast<std::size_t>(count)) {
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const double x = 40.0 + 30.0 * static_cast<double>(i % 8);
      const std::size_t row = i / 8;
      const double y = 40.0 + 30.0 * static_cast<double>(row);
      observations[i].uvd_ref = observations[i].uvd_cur = {x, y, 10.0};
      observations[i].change = observations[i].difference = 0.05F;
    }
    motion.converged = true;
    motion.inliers = count;
    motion.error_px = 0.1;
  }
  CheckInput input() const { return {motion, observations, references, kModel, 100, 0.0, covered}; }

  std::vector<RigidTransform> references;
  std::vector<Observation> observations;
  Motion motion;
  double covered = 1.0;
  VoParams params;
  CameraNoise noise;
  Caution caution;
  std::vector<float> scratch;
};

// What a rough camera's views show: patches that scatter by so much across the rows.
CameraNoise rough(double scatter_px) {
  CameraNoise noise;
  Frame frame{VoParams{}};
  frame.row_scatter_px = scatter_px;
  frame.grey_scatter = 12.0;
  for (int i = 0; i < 200; ++i) noise.add_views(frame);
  return noise;
}

TEST(Checks, AnImageThatRepeatsItselfBitForBitFailsHoweverLittleMoved) {
  Seen seen;
  CheckInput input = seen.input();
  EXPECT_FALSE(check_hanging_camera(input, seen.noise, seen.scratch).fails());
  input.camera_repeats = true;
  EXPECT_TRUE(check_hanging_camera(input, seen.noise, seen.scratch).fails());
}

// A camera of which much was learned.
CameraNoise settled() {
  CameraNoise noise;
  for (int i = 0; i < 1000; ++i) noise.add_motion({});
  return noise;
}

TEST(Uncertainty, OfARollingShutterIsLargerWhereTheSpeedBeforeIsNotKnown) {
  Seen seen;
  const CameraNoise noise = settled();
  StereoModel rolling = kModel;
  rolling.readout_s = 0.02;
  const auto factor = [&](const StereoModel& model, bool known) {
    CheckInput input{seen.motion, seen.observations, seen.references, model, 100};
    input.speed_known = known;
    return doubt_factor(input, noise, {});
  };
  EXPECT_GT(factor(rolling, false), 2.0);
  EXPECT_NEAR(factor(rolling, true), 1.0, 1e-4);
  EXPECT_NEAR(factor(kModel, false), 1.0, 1e-4) << "all rows at once";
}

TEST(Uncertainty, OfFirstMotionsIsLarger) {
  Seen seen;
  CameraNoise noise;
  double before = doubt_factor(seen.input(), noise, {});
  EXPECT_EQ(before, 3.0);
  for (int i = 0; i < 3; ++i) {
    noise.add_motion({});
    const double now = doubt_factor(seen.input(), noise, {});
    EXPECT_LT(now, before);
    EXPECT_GT(now, 1.0);
    before = now;
  }
  noise.reset();
  EXPECT_EQ(doubt_factor(seen.input(), noise, {}), 3.0) << "another camera";
}

TEST(Uncertainty, GrowsWhereSurfacesChangeNearlyAsMuchAsIsRefused) {
  Seen seen;
  const CameraNoise noise = settled();
  const auto factor = [&](double ratio) { return doubt_factor(seen.input(), noise, {4.0 * ratio, 4.0, true}); };
  EXPECT_NEAR(factor(0.0), 1.0, 1e-4);
  EXPECT_LT(factor(0.4), 1.1);
  EXPECT_GT(factor(0.8), 1.5);
  EXPECT_GT(factor(1.0), 3.0);
  EXPECT_EQ(factor(50.0), factor(1.0)) << "refused anyhow";
}

TEST(Checks, TooFewInliersFail) {
  Seen seen;
  EXPECT_FALSE(check_inliers(seen.input(), seen.params).fails());
  seen.motion.inliers = seen.params.min_inliers - 1;
  EXPECT_TRUE(check_inliers(seen.input(), seen.params).fails());
}

TEST(Checks, InliersOnALineFail) {
  Seen seen;
  EXPECT_FALSE(check_spread(seen.input(), seen.params).fails());
  for (Observation& o : seen.observations) o.uvd_cur.y() = 100.0;
  EXPECT_TRUE(check_spread(seen.input(), seen.params).fails());
}

TEST(Checks, TheSameScatterFailsForACleanCameraAndNotForARoughOne) {
  Seen seen;
  seen.motion.error_px = 1.5;
  EXPECT_TRUE(check_positions(seen.input(), rough(0.05), seen.params).fails());
  EXPECT_FALSE(check_positions(seen.input(), rough(0.3), seen.params).fails());
}

TEST(Checks, DisparitiesThatDoNotFitTheMotionFail) {
  Seen seen;
  for (std::size_t i = 0; i < seen.observations.size(); ++i)
    seen.observations[i].uvd_cur.z() += i % 2 == 0 ? 1.0 : -1.0;
  seen.observations.back().inlier = false;
  seen.observations.back().uvd_cur.z() = 40.0;
  EXPECT_NEAR(disparity_error_px(seen.input()), 1.0, 1e-9) << "outliers do not count";
  EXPECT_TRUE(check_disparities(seen.input(), rough(0.05), seen.params).fails());
  EXPECT_FALSE(check_disparities(seen.input(), rough(0.3), seen.params).fails());
}

TEST(Checks, ACommonShiftThatWasSolvedForIsNoErrorOfTheDisparities) {
  Seen seen;
  for (Observation& o : seen.observations) o.uvd_cur.z() += 2.0;
  seen.motion.shift_px = 2.0;
  EXPECT_NEAR(disparity_error_px(seen.input()), 0.0, 1e-9);
}

TEST(Checks, ASmallPartOfThePictureMustFitBetter) {
  Seen seen;
  for (std::size_t i = 0; i < seen.observations.size(); ++i)
    seen.observations[i].uvd_cur.z() += i % 2 == 0 ? 0.6 : -0.6;
  const CameraNoise noise = rough(0.05);
  EXPECT_FALSE(check_disparities(seen.input(), noise, seen.params).fails());
  seen.covered = 0.1;
  EXPECT_TRUE(check_disparities(seen.input(), noise, seen.params).fails());
}

TEST(Checks, ContradictionIsAShareOfTheCellsThatVoted) {
  Seen seen;
  CellVotes votes;
  votes.cells = 120;
  votes.agree = 80;
  votes.contradict = 10;
  EXPECT_FALSE(check_contradiction(votes, seen.caution, seen.params).fails());
  votes.contradict = 20;
  EXPECT_TRUE(check_contradiction(votes, seen.caution, seen.params).fails());
}

TEST(Checks, SurfacesThatChangeMoreThanLeftAndRightDifferAreRunningGround) {
  Seen seen;
  seen.motion.error_px = 0.33;
  for (Observation& o : seen.observations) o.change = 0.15F, o.difference = 0.03F;
  EXPECT_TRUE(check_running_ground(seen.input(), rough(0.06), seen.caution, seen.params, seen.scratch).fails());
  // Blur and compression change the picture of both cameras alike.
  for (Observation& o : seen.observations) o.change = 0.12F, o.difference = 0.065F;
  EXPECT_FALSE(check_running_ground(seen.input(), rough(0.25), seen.caution, seen.params, seen.scratch).fails());
}

TEST(Checks, DisparitiesThatFitBadlyMakeChangingSurfacesMoreSuspicious) {
  Seen seen;
  for (Observation& o : seen.observations) o.change = 0.12F, o.difference = 0.05F;
  const auto value = [&] {
    return check_running_ground(seen.input(), seen.noise, seen.caution, seen.params, seen.scratch).value;
  };
  const double as_usual = value();
  const double expected_px = seen.noise.expected_error_px();
  for (Observation& o : seen.observations) o.uvd_cur.z() += expected_px;
  EXPECT_NEAR(value(), as_usual, 1e-9) << "no more than cameras are used to";
  for (Observation& o : seen.observations) o.uvd_cur.z() += 1.8 * expected_px;
  EXPECT_NEAR(value(), 2.0 * as_usual, 1e-6);
}

TEST(Checks, UnequalCamerasAreNoRunningGround) {
  Seen seen;
  for (Observation& o : seen.observations) o.change = 0.01F, o.difference = 0.2F;
  EXPECT_EQ(check_running_ground(seen.input(), seen.noise, seen.caution, seen.params, seen.scratch).value, 0.0);
}

TEST(Checks, ACameraThatRepeatsItsLastImageHangs) {
  Seen seen;
  // The left image moves by 8 px, the right one stands: disparities follow the left one.
  for (Observation& o : seen.observations) o.uvd_cur.x() += 8.0, o.uvd_cur.z() += 8.0;
  EXPECT_TRUE(check_hanging_camera(seen.input(), seen.noise, seen.scratch).fails());
  for (Observation& o : seen.observations) o.uvd_cur.z() -= 8.0;
  EXPECT_FALSE(check_hanging_camera(seen.input(), seen.noise, seen.scratch).fails());
  Seen standing;
  EXPECT_FALSE(check_hanging_camera(standing.input(), standing.noise, standing.scratch).applies);
}

TEST(Checks, AGoodShareOfTheFeaturesMustBeFoundAndMoreUnderCaution) {
  Seen seen(10);  // of 100
  EXPECT_FALSE(check_found_again(seen.input(), seen.caution).fails());
  Checks running;
  running[Check::running_ground] = {2.0, 1.0, true};
  seen.caution.learn(running);
  EXPECT_TRUE(check_found_again(seen.input(), seen.caution).fails());
  Seen few(3);
  EXPECT_TRUE(check_found_again(few.input(), few.caution).fails());
}

TEST(Checks, AMotionKnownToAFifthOfItselfIsWeak) {
  Seen seen;
  seen.motion.T_prev_cur.t.z() = 1.0;
  Matrix6d covariance = Matrix6d::Identity() * 1e-4;
  EXPECT_FALSE(check_uncertainty(seen.input(), covariance, seen.params).fails());
  covariance *= 400.0;
  Checks checks;
  checks[Check::uncertainty] = check_uncertainty(seen.input(), covariance, seen.params);
  EXPECT_EQ(verdict(checks), Status::weak);
  EXPECT_LT(quality(checks), 50);
}

TEST(Checks, WhoStandsIsKnownByTheDistanceOfWhatIsSeen) {
  Seen seen;  // at 6 m
  EXPECT_FALSE(check_uncertainty(seen.input(), Matrix6d::Identity() * 1e-5, seen.params).fails());
  EXPECT_TRUE(check_uncertainty(seen.input(), Matrix6d::Identity() * 1e-3, seen.params).fails());
}

TEST(Checks, SpreadIsTheRatioOfTheAxesOfTheInliersPlaces) {
  std::vector<Observation> four(4);
  four[0].uvd_cur = {0.0, 0.0, 5.0};
  four[1].uvd_cur = {40.0, 0.0, 5.0};
  four[2].uvd_cur = {40.0, 20.0, 5.0};
  four[3].uvd_cur = {0.0, 20.0, 5.0};
  EXPECT_NEAR(spread_ratio(four), 0.25, 1e-12) << "(20 / 40)^2";
  four[2].uvd_cur.y() = four[3].uvd_cur.y() = 40.0;
  EXPECT_NEAR(spread_ratio(four), 1.0, 1e-12);
  four[2].inlier = four[3].inlier = false;
  EXPECT_EQ(spread_ratio(four), 0.0) << "two lie on a line";
}

TEST(Checks, ACommonChangeOfLightIsNoneAndAGlowIsOne) {
  Seen seen;
  for (Observation& o : seen.observations) o.brighter = 25.0F;
  EXPECT_EQ(change_of_light(seen.observations, seen.scratch), 0.0);
  for (std::size_t i = 0; i < seen.observations.size(); i += 4) seen.observations[i].brighter = 75.0F;
  EXPECT_EQ(change_of_light(seen.observations, seen.scratch), 50.0) << "of a quarter";
  EXPECT_EQ(change_of_light({}, seen.scratch), 0.0);
}

TEST(Verdict, FollowsTheFirstCheckThatFails) {
  Checks checks;
  EXPECT_EQ(verdict(checks), Status::valid);
  checks[Check::uncertainty] = {2.0, 1.0, true};
  EXPECT_EQ(verdict(checks), Status::weak);
  checks[Check::rival] = {2.0, 1.0, true};
  EXPECT_EQ(verdict(checks), Status::ambiguous);
  checks[Check::positions] = {2.0, 1.0, true};
  EXPECT_EQ(verdict(checks), Status::reprojection_error);
  checks[Check::inliers] = {std::nan(""), 1.0, true};
  EXPECT_EQ(verdict(checks), Status::too_few_features) << "not a number is no pass";
  EXPECT_EQ(checks.failed(), 1U << 0 | 1U << 2 | 1U << 8 | 1U << 9);
}

TEST(Verdict, EveryCheckHasANameOfItsOwn) {
  for (std::size_t k = 0; k < kChecks; ++k) {
    EXPECT_STRNE(check_name(static_cast<Check>(k)), "unknown");
    for (std::size_t j = 0; j < k; ++j) {
      EXPECT_STRNE(check_name(static_cast<Check>(k)), check_name(static_cast<Check>(j)));
    }
  }
}

TEST(Caution, LastsUntilAValidFrameOrForThreeFrames) {
  Caution caution;
  EXPECT_EQ(caution.bound_scale(), 1.0);
  Checks contradicted;
  contradicted[Check::contradiction] = {0.2, 0.14, true};
  caution.learn(contradicted);
  for (int i = 0; i < 3; ++i) {
    caution.next(false);
    EXPECT_LT(caution.bound_scale(), 1.0) << i;
  }
  caution.next(false);
  EXPECT_EQ(caution.bound_scale(), 1.0);
  Checks running;
  running[Check::running_ground] = {5.0, 4.0, true};
  caution.learn(running);
  for (int i = 0; i < 10; ++i) caution.next(false);
  EXPECT_LT(caution.bound_scale(), 1.0);
  caution.next(true);
  EXPECT_EQ(caution.bound_scale(), 1.0);
}

TEST(Caution, IsRenewedByTheFullBoundOnly) {
  Caution caution;
  Checks contradicted;
  contradicted[Check::contradiction] = {0.2, 0.14, true};
  caution.learn(contradicted);
  // Under caution half the bound is allowed, and 0.1 fails; but it is no reason for more caution.
  contradicted[Check::contradiction] = {0.1, 0.07, true};
  for (int i = 0; i < 4; ++i) {
    caution.learn(contradicted);
    caution.next(false);
  }
  EXPECT_EQ(caution.bound_scale(), 1.0);
}

TEST(Uncertainty, GrowsWithNoiseCoverageAndLight) {
  Seen seen;
  seen.motion.covariance = Matrix6d::Identity();
  const SelfCheck check(kModel, seen.params);
  const double least = uncertainty(seen.input(), false, seen.params, check, seen.scratch)(0, 0);
  seen.motion.error_px = 1.0;
  const double noisy = uncertainty(seen.input(), false, seen.params, check, seen.scratch)(0, 0);
  EXPECT_GT(noisy, 5.0 * least);
  seen.covered = 0.5;
  const double one_half = uncertainty(seen.input(), false, seen.params, check, seen.scratch)(0, 0);
  EXPECT_GT(one_half, 4.0 * noisy) << "the square of what is missing, and patches that overlap more";
  EXPECT_LT(one_half, 5.0 * noisy);
  seen.covered = 1.0;
  for (std::size_t i = 0; i < seen.observations.size(); ++i) seen.observations[i].brighter = i % 3 == 0 ? 30.0F : 0.0F;
  EXPECT_GT(uncertainty(seen.input(), false, seen.params, check, seen.scratch)(0, 0), 3.0 * noisy);
}

TEST(Uncertainty, OfAMotionThatTakesBackTheErrorBefore) {
  const Matrix6d now = Matrix6d::Identity();
  EXPECT_EQ(with_error_taken_back(now, 0.5 * now), now) << "the previous frame was known better";
  EXPECT_NEAR(with_error_taken_back(now, 4.0 * now)(0, 0), 1.0 + 0.75 * 4.0, 1e-12);
}

TEST(Uncertainty, QualityIsFiftyWhereTheMotionIsJustKnownWellEnough) {
  Checks checks;
  EXPECT_EQ(quality(checks), 0);
  checks[Check::uncertainty] = {1.0, 1.0, true};
  EXPECT_EQ(quality(checks), 50);
  checks[Check::uncertainty] = {0.1, 1.0, true};
  EXPECT_EQ(quality(checks), 99);
}

}  // namespace
}  // namespace cliquevo::vo
