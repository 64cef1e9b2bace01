// SPDX-License-Identifier: BSD-3-Clause
// Two frames in, a judged motion out: on walls whose motion is known, and where no motion is the right one.
#include "core/vo/estimator.h"

#include <memory>

#include <gtest/gtest.h>

#include "tests/unit/vo/walls.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel = Walls::model();

// The steps before and around the estimator, without the frames of a drive.
class EstimatorTest : public testing::Test {
 protected:
  std::unique_ptr<Frame> frame(const Walls::Views& views) {
    auto out = std::make_unique<Frame>(params_);
    out->left.copy_from(views.left.cview());
    out->right.copy_from(views.right.cview());
    detector_.detect(views.left.cview(), views.disparity.cview(), {}, 0.0, out->features);
    out->descriptors.extract(views.filtered.cview(), out->features, params_.descriptor_window);
    out->coarse_descriptors.extract_coarse(views.filtered.cview(), out->features);
    tracker_.measure_views(views.disparity.cview(), check_, *out);
    tracker_.refine_disparities({check_}, *out);
    estimator_.prepare(views.disparity.cview(), *out);
    return out;
  }
  Comparison compare(const Walls::Views& before, const Walls::Views& now, const RigidTransform& prediction = {}) {
    reference_ = frame(before);
    current_ = frame(now);
    StepTimes times;
    return estimator_.compare(
        {*reference_, nullptr, *current_, now.disparity.cview(), {&prediction, 1}, check_, noise_, caution_}, times);
  }

  VoParams params_;
  FeatureDetector detector_{kModel, params_};
  Tracker tracker_{kModel, params_};
  Estimator estimator_{kModel, params_};
  SelfCheck check_{kModel, params_};
  CameraNoise noise_;
  Caution caution_;
  std::unique_ptr<Frame> reference_, current_;
};

TEST_F(EstimatorTest, FindsTheMotionWithoutAPredictionAndKnowsHowWell) {
  const Walls walls;
  const Comparison found = compare(walls.from(0.0, 0.0), walls.from(0.04, -0.015));
  ASSERT_EQ(found.status, Status::valid) << status_name(found.status);
  EXPECT_TRUE(found.started);
  EXPECT_EQ(found.checks.failed(), 0U);
  EXPECT_NEAR((found.motion.T_prev_cur.t - Eigen::Vector3d(0.04, -0.015, 0.0)).norm(), 0.0, 0.001);
  EXPECT_LT(found.motion.T_prev_cur.angle(), 0.0005);
  const double sigma_m = std::sqrt(found.motion.covariance.topLeftCorner<3, 3>().trace());
  EXPECT_LT(sigma_m, 0.004);
  EXPECT_GT(sigma_m, 1e-5);
  EXPECT_GE(found.clique, params_.min_inliers);
  EXPECT_EQ(static_cast<int>(estimator_.observations().size()) >= found.motion.inliers, true);
  EXPECT_GT(found.key_overlap, 0.6) << "of the reference, where there is no key frame";
}

TEST_F(EstimatorTest, EveryCheckThatAppliesHasAValueAndABound) {
  const Walls walls;
  const Comparison found = compare(walls.from(0.0, 0.0), walls.from(0.02, 0.0));
  for (std::size_t k = 0; k < kChecks; ++k) {
    const Evidence& e = found.checks[static_cast<Check>(k)];
    if (static_cast<Check>(k) != Check::hanging_camera) {
      EXPECT_TRUE(e.applies) << check_name(static_cast<Check>(k));
    }
    if (!e.applies) continue;
    EXPECT_GT(e.bound, 0.0) << check_name(static_cast<Check>(k));
    EXPECT_GE(e.ratio(), 0.0);
    EXPECT_LE(e.ratio(), 1.0) << check_name(static_cast<Check>(k));
  }
}

TEST_F(EstimatorTest, OfABlankPictureThereIsNoMotion) {
  const Walls walls;
  Walls::Views blank = walls.from(0.0, 0.0);
  for (Image<std::uint8_t>* image : {&blank.left, &blank.right, &blank.filtered}) image->fill(90);
  const Comparison found = compare(walls.from(0.0, 0.0), blank);
  EXPECT_EQ(found.status, Status::too_few_features);
  EXPECT_FALSE(found.started);
  EXPECT_EQ(found.motion.inliers, 0);
}

TEST_F(EstimatorTest, AnotherWorldHasNoMotionEither) {
  EXPECT_NE(compare(Walls(1).from(0.0, 0.0), Walls(2).from(0.0, 0.0)).status, Status::valid);
}

TEST_F(EstimatorTest, TwoHalvesThatMoveDifferentlyAreAmbiguous) {
  const Walls walls;
  const Comparison found = compare(walls.from({}), walls.from({.x_m = 0.05, .right_half_x_m = 0.1}));
  EXPECT_EQ(found.status, Status::ambiguous) << status_name(found.status);
  EXPECT_TRUE(found.checks[Check::rival].fails() || found.checks[Check::contradiction].fails());
}

TEST_F(EstimatorTest, ARightImageThatStandsStillIsNoticed) {
  const Walls walls;
  const Walls::Views before = walls.from(0.0, 0.0);
  Walls::Views now = walls.from(0.05, 0.0);
  now.right.copy_from(before.right.cview());
  EXPECT_NE(compare(before, now).status, Status::valid);
}

TEST_F(EstimatorTest, CautionMakesItStricter) {
  const Walls walls;
  const Comparison calm = compare(walls.from(0.0, 0.0), walls.from(0.02, 0.0));
  Checks suspicious;
  suspicious[Check::running_ground] = {2.0, 1.0, true};
  caution_.learn(suspicious);
  const Comparison cautious = compare(walls.from(0.0, 0.0), walls.from(0.02, 0.0));
  for (const Check check : {Check::running_ground, Check::contradiction}) {
    EXPECT_NEAR(cautious.checks[check].bound, 0.5 * calm.checks[check].bound, 1e-12) << check_name(check);
  }
  EXPECT_GT(cautious.checks[Check::found_again].value, calm.checks[Check::found_again].value);
}

}  // namespace
}  // namespace cliquevo::vo
