// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/clique.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "core/base/rigid_transform.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 0.0};

RigidTransform some_motion() {
  Vector6d x;
  x << 0.02, -0.01, 0.15, 0.01, -0.02, 0.005;
  return perturb_left({}, x);
}

// `count` matches of which the first `good` follow the motion.
std::vector<PointPair> make_pairs(int count, int good, std::mt19937& rng) {
  std::uniform_real_distribution<double> x(-2.0, 2.0), y(-1.0, 1.0), z(2.0, 10.0);
  const RigidTransform T = some_motion();
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    PointPair p;
    p.b = {x(rng), y(rng), z(rng)};
    p.a = i < good ? T * p.b : Eigen::Vector3d(x(rng), y(rng), z(rng));
    pairs.push_back(p);
  }
  return pairs;
}

class CliqueOfEitherTest : public testing::TestWithParam<Consistency> {};

TEST_P(CliqueOfEitherTest, FindsAllTrueMatchesAmongNinetyPercentFalseOnes) {
  std::mt19937 rng(3);
  VoParams params;
  params.consistency = GetParam();
  params.match_disparity_sigma_px = 0.05;  // the points are exact: a tight test
  params.match_sigma_px = 0.05;
  CliqueFinder finder(kModel, params);
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<PointPair> pairs = make_pairs(300, 30, rng);
    std::vector<int> clique;
    finder.find(pairs, clique);
    std::vector<int> sorted = clique;
    std::sort(sorted.begin(), sorted.end());
    int true_members = 0;
    for (const int i : sorted) true_members += i < 30 ? 1 : 0;
    EXPECT_EQ(true_members, 30);
    EXPECT_LE(static_cast<int>(sorted.size()) - true_members, 3) << "chance neighbours";
  }
}

INSTANTIATE_TEST_SUITE_P(Both, CliqueOfEitherTest, testing::Values(Consistency::fixed, Consistency::range_aware),
                         [](const auto& p) { return p.param == Consistency::fixed ? "fixed" : "range_aware"; });

TEST(Clique, TheRangeAwareTestKeepsFarPointsThatTheFixedOneLoses) {
  std::mt19937 rng(4);
  std::normal_distribution<double> noise(0.0, 0.3);  // px of disparity
  const RigidTransform T = some_motion();
  std::uniform_real_distribution<double> u(0, 511), v(0, 383), d(1.5, 6.0);
  std::vector<PointPair> pairs;
  for (int i = 0; i < 100; ++i) {
    const double ui = u(rng), vi = v(rng), di = d(rng);
    const Eigen::Vector3d exact = kModel.triangulate(ui, vi, di);
    const Eigen::Vector3d moved = T * exact;
    const double moved_d = kModel.fx_px * kModel.baseline_m / moved.z();
    PointPair p;
    p.b = exact * (di / (di + noise(rng)));
    p.a = moved * (moved_d / (moved_d + noise(rng)));
    pairs.push_back(p);
  }
  VoParams params;
  std::vector<int> fixed, aware;
  params.consistency = Consistency::fixed;
  CliqueFinder(kModel, params).find(pairs, fixed);
  params.consistency = Consistency::range_aware;
  CliqueFinder(kModel, params).find(pairs, aware);
  EXPECT_GT(aware.size(), 80u);
  EXPECT_LT(fixed.size(), aware.size() / 2);
}

TEST(Clique, IsTheSameEveryTimeAndHasNoMemberTwice) {
  std::mt19937 rng(5);
  const std::vector<PointPair> pairs = make_pairs(200, 100, rng);
  CliqueFinder finder(kModel, {});
  std::vector<int> once, again;
  finder.find(pairs, once);
  finder.find(pairs, again);
  EXPECT_EQ(once, again);
  std::sort(once.begin(), once.end());
  EXPECT_EQ(std::adjacent_find(once.begin(), once.end()), once.end());
}

TEST(Clique, ARivalMotionIsFoundBesideTheFirst) {
  std::mt19937 rng(6);
  std::vector<PointPair> pairs = make_pairs(100, 60, rng);
  Vector6d x;
  x << 0.5, 0.0, -0.6, 0.0, 0.3, 0.0;
  const RigidTransform other = perturb_left({}, x);
  for (std::size_t i = 60; i < 100; ++i) pairs[i].a = other * pairs[i].b;
  VoParams params;
  params.match_disparity_sigma_px = 0.05;
  params.match_sigma_px = 0.05;
  CliqueFinder finder(kModel, params);
  std::vector<int> clique, rest, rival;
  finder.find(pairs, clique);
  EXPECT_GE(clique.size(), 60u);
  for (int i = 0; i < 100; ++i) {
    if (std::find(clique.begin(), clique.end(), i) == clique.end()) rest.push_back(i);
  }
  finder.among(100, rest, rival);
  EXPECT_GE(rival.size(), 36u);
  EXPECT_LE(rival.size(), 42u);
}

TEST(Clique, NoMatchesGiveNoClique) {
  CliqueFinder finder(kModel, {});
  std::vector<int> clique = {1, 2};
  finder.find({}, clique);
  EXPECT_TRUE(clique.empty());
}

}  // namespace
}  // namespace cliquevo::vo
