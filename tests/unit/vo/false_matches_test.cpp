// SPDX-License-Identifier: BSD-3-Clause
// From matches to motion, with false ones planted among them: clique, closed-form start and solution.
#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/vo/clique.h"
#include "core/vo/motion.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 0.0};

Eigen::Vector3d project(const Eigen::Vector3d& p) {
  return {kModel.fx_px * p.x() / p.z() + kModel.cx_px, kModel.fy_px * p.y() / p.z() + kModel.cy_px,
          kModel.fx_px * kModel.baseline_m / p.z()};
}

PointPair points_of(const Observation& o) {
  return {kModel.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z()),
          kModel.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z())};
}

Motion motion_of(const std::vector<Observation>& all) {
  const VoParams params;
  std::vector<PointPair> pairs;
  for (const Observation& o : all) pairs.push_back(points_of(o));
  std::vector<int> clique;
  CliqueFinder(kModel, params).find(pairs, clique);
  RigidTransform start;
  if (!align_points(pairs, clique, start)) return {};
  std::vector<Observation> members;
  for (const int i : clique) members.push_back(all[static_cast<std::size_t>(i)]);
  return MotionSolver(kModel, params)
      .solve_tightening(members, {RigidTransform{}}, start, {params.match_sigma_px, params.match_disparity_sigma_px});
}

class FalseMatches : public testing::TestWithParam<int> {};

TEST_P(FalseMatches, LeaveTheMotionThatTheTrueOnesGive) {
  const int percent = GetParam();
  std::mt19937 rng(static_cast<unsigned>(percent));
  std::uniform_real_distribution<double> u(20, 490), v(20, 360), d(4.0, 40.0), small(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.03);  // px
  const int count = 350;
  const int good = count * (100 - percent) / 100;
  for (int trial = 0; trial < 20; ++trial) {
    Vector6d x;
    for (int k = 0; k < 6; ++k) x[k] = small(rng) * (k < 3 ? 0.2 : 0.04);
    const RigidTransform T = perturb_left({}, x);
    std::vector<Observation> all;
    while (static_cast<int>(all.size()) < count) {
      Observation o;
      o.uvd_cur = {u(rng), v(rng), d(rng)};
      if (static_cast<int>(all.size()) < good) {
        o.uvd_ref = project(T * kModel.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z()));
        if (o.uvd_ref.z() < 1.0) continue;
        for (int k = 0; k < 3; ++k) o.uvd_ref[k] += noise(rng);
      } else {
        o.uvd_ref = {u(rng), v(rng), d(rng)};
      }
      all.push_back(o);
    }
    const Motion alone = motion_of({all.begin(), all.begin() + good});
    ASSERT_TRUE(alone.converged);
    std::shuffle(all.begin(), all.end(), rng);
    const Motion among = motion_of(all);
    ASSERT_TRUE(among.converged) << trial;
    const RigidTransform apart = alone.T_prev_cur.inverse() * among.T_prev_cur;
    EXPECT_LT(apart.t.norm(), 0.001) << trial;
    EXPECT_LT(apart.angle() * 57.29577951308232, 0.01) << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(Percent, FalseMatches, testing::Values(10, 30, 50, 70, 80, 90));

}  // namespace
}  // namespace cliquevo::vo
