// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/motion.h"

#include <random>

#include <gtest/gtest.h>

namespace cliquevo::vo {
namespace {

const StereoModel kModel{512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 1.5};

RigidTransform some_motion(std::mt19937& rng, double size) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Vector6d x;
  for (int i = 0; i < 6; ++i) x[i] = size * u(rng) * (i < 3 ? 0.3 : 0.05);
  return perturb_left({}, x);
}

Eigen::Vector3d project(const Eigen::Vector3d& p) {
  return {kModel.fx_px * p.x() / p.z() + kModel.cx_px, kModel.fy_px * p.y() / p.z() + kModel.cy_px,
          kModel.fx_px * kModel.baseline_m / p.z() - kModel.doffs_px};
}

// Observations of random points under T, with noise; the last `outliers` are wrong.
std::vector<Observation> observe(const RigidTransform& T_ref_cur, int count, int outliers, double noise_px,
                                 std::mt19937& rng, int reference = 0) {
  std::uniform_real_distribution<double> u(20, 490), v(20, 360), d(2.0, 40.0), wrong(10.0, 40.0);
  std::normal_distribution<double> n(0.0, 1.0);
  std::vector<Observation> out;
  while (static_cast<int>(out.size()) < count) {
    Observation o;
    o.uvd_cur = {u(rng), v(rng), d(rng)};
    const Eigen::Vector3d in_ref = T_ref_cur * kModel.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z());
    if (in_ref.z() < 0.5) continue;
    o.uvd_ref = project(in_ref);
    for (int k = 0; k < 3; ++k) o.uvd_cur[k] += noise_px * n(rng);
    o.uvd_ref.z() += noise_px * n(rng);  // a feature's place in the reference is exact: it defines the feature
    if (static_cast<int>(out.size()) >= count - outliers)
      o.uvd_cur.head<2>() += Eigen::Vector2d(wrong(rng), -wrong(rng));
    o.reference = reference;
    out.push_back(o);
  }
  return out;
}

// The search ends where a step would gain three thousandths of a standard deviation: some micrometres here.
constexpr double kExact = 1e-6;

TEST(Motion, IsExactOnExactObservationsWhateverTheStart) {
  std::mt19937 rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const RigidTransform T = some_motion(rng, 1.0);
    std::vector<Observation> observations = observe(T, 60, 0, 0.0, rng);
    const Motion m = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}}, {}, {0.3, 0.3});
    ASSERT_TRUE(m.converged);
    EXPECT_LT(left_difference(T, m.T_prev_cur).norm(), kExact);
    EXPECT_EQ(m.inliers, 60);
  }
}

TEST(Motion, DropsWrongMatchesAndStaysWithinItsCovariance) {
  std::mt19937 rng(2);
  double nees = 0.0;
  const int trials = 200;
  for (int trial = 0; trial < trials; ++trial) {
    const RigidTransform T = some_motion(rng, 0.5);
    std::vector<Observation> observations = observe(T, 120, 12, 0.3, rng);
    const Motion m = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}}, {}, {0.3, 0.3});
    ASSERT_TRUE(m.converged);
    for (std::size_t i = 108; i < 120; ++i) EXPECT_FALSE(observations[i].inlier);
    const Vector6d e = left_difference(m.T_prev_cur, T);
    nees += e.dot(m.covariance.inverse() * e);
  }
  // Six degrees of freedom: a mean of 6 over 200 trials, within a factor for Huber's loss of efficiency.
  EXPECT_GT(nees / trials, 4.0);
  EXPECT_LT(nees / trials, 9.0);
}

TEST(Motion, TwoReferencesAgreeOnOneMotion) {
  std::mt19937 rng(3);
  const RigidTransform T_prev_cur = some_motion(rng, 0.5);
  const RigidTransform T_prev_key = some_motion(rng, 1.0);
  std::vector<Observation> observations = observe(T_prev_cur, 40, 0, 0.0, rng, 0);
  const std::vector<Observation> more = observe(T_prev_key.inverse() * T_prev_cur, 40, 0, 0.0, rng, 1);
  observations.insert(observations.end(), more.begin(), more.end());
  const Motion m = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}, T_prev_key}, {}, {0.3, 0.3});
  ASSERT_TRUE(m.converged);
  EXPECT_LT(left_difference(T_prev_cur, m.T_prev_cur).norm(), kExact);
  EXPECT_EQ(m.inliers, 80);
}

// What is known of the previous frame's place is no better than what is looked for.
TEST(Motion, BesideAKeptReferenceThePreviousFrameCountsForAQuarter) {
  std::mt19937 rng(4);
  const RigidTransform seen_from_previous = some_motion(rng, 0.5);
  RigidTransform seen_from_key = seen_from_previous;
  seen_from_key.t += Eigen::Vector3d(0.001, 0.0, 0.0);
  std::mt19937 points(5);
  std::vector<Observation> observations = observe(seen_from_previous, 100, 0, 0.0, points, 0);
  points.seed(5);  // the same points
  const std::vector<Observation> more = observe(seen_from_key, 100, 0, 0.0, points, 1);
  observations.insert(observations.end(), more.begin(), more.end());
  const Motion m = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}, RigidTransform{}}, {}, {0.3, 0.3});
  ASSERT_TRUE(m.converged);
  EXPECT_NEAR(m.T_prev_cur.t.x(), seen_from_previous.t.x() + 0.0008, 1e-5);
}

// A rig that flexes shifts all disparities of a frame: solved for together with the motion where it is expected.
TEST(Motion, ACommonShiftOfTheCurrentDisparitiesIsSolvedForBesideTheMotion) {
  std::mt19937 rng(6);
  const RigidTransform T = some_motion(rng, 0.5);
  std::vector<Observation> observations = observe(T, 120, 0, 0.0, rng);
  for (Observation& o : observations) o.uvd_cur.z() += 1.2;
  std::vector<Observation> again = observations;
  const Motion with = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}}, {}, {0.3, 0.3, 1e3});
  ASSERT_TRUE(with.converged);
  EXPECT_NEAR(with.shift_px, 1.2, 1e-3);
  EXPECT_LT(left_difference(T, with.T_prev_cur).norm(), 1e-3);
  const Motion without = MotionSolver(kModel, {}).solve(again, {RigidTransform{}}, {}, {0.3, 0.3});
  EXPECT_EQ(without.shift_px, 0.0);
  EXPECT_GT(left_difference(T, without.T_prev_cur).norm(), 10.0 * left_difference(T, with.T_prev_cur).norm());
}

TEST(Motion, AStiffRigsPriorKeepsTheShiftAtZeroButItsReadingIsFree) {
  std::mt19937 rng(7);
  const RigidTransform T = some_motion(rng, 0.5);
  std::vector<Observation> observations = observe(T, 120, 0, 0.0, rng);
  for (Observation& o : observations) o.uvd_cur.z() += 0.4;
  const Motion m = MotionSolver(kModel, {}).solve(observations, {RigidTransform{}}, {}, {0.3, 0.3, 1e-3});
  ASSERT_TRUE(m.converged);
  EXPECT_LT(std::abs(m.shift_px), 0.02);
  EXPECT_NEAR(m.free_shift_px, 0.4, 0.1);
}

TEST(Motion, ClosedFormAlignmentIsExactAndRefusesALine) {
  std::mt19937 rng(4);
  const RigidTransform T = some_motion(rng, 3.0);
  std::vector<PointPair> pairs;
  std::vector<int> all;
  std::uniform_real_distribution<double> x(-3, 3), z(2, 9);
  for (int i = 0; i < 20; ++i) {
    PointPair p;
    p.b = {x(rng), x(rng), z(rng)};
    p.a = T * p.b;
    pairs.push_back(p);
    all.push_back(i);
  }
  RigidTransform found;
  ASSERT_TRUE(align_points(pairs, all, found));
  EXPECT_LT(left_difference(T, found).norm(), 1e-9);
  for (int i = 0; i < 20; ++i) {
    pairs[static_cast<std::size_t>(i)].b = {0.1 * i, 0.0, 5.0};
    pairs[static_cast<std::size_t>(i)].a = {0.1 * i, 0.0, 4.9};
  }
  EXPECT_FALSE(align_points(pairs, all, found));
  EXPECT_FALSE(align_points(pairs, {0, 1}, found));
}

TEST(Motion, WithoutObservationsThereIsNoMotionAndNoNan) {
  std::vector<Observation> none;
  const Motion m = MotionSolver(kModel, {}).solve(none, {RigidTransform{}}, {}, {0.3, 0.3});
  EXPECT_FALSE(m.converged);
  EXPECT_TRUE(m.covariance.allFinite());
  EXPECT_TRUE(m.T_prev_cur.is_finite());
}

}  // namespace
}  // namespace cliquevo::vo
