// SPDX-License-Identifier: BSD-3-Clause
// While nothing is seen, the pose is no further off than if the camera had gone on as in the last frame, or had
// stopped: over all gaps of the simulator's courses, by their exact poses.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/dead_reckoning.h"
#include "drivers/simulator.h"
#include "drivers/simulator/course.h"

namespace cliquevo::vo {
namespace {

constexpr int kFrames = 1200;
constexpr int kKnown = 90;                                // frames before the first gap
constexpr int kBetween = 7;                               // frames from the beginning of one gap to that of the next
constexpr double kSpare = 1.1;                            // of the better of both
constexpr double kSpare_m = 0.012;                        // who turns on the spot does not move at all
constexpr double kNoise_m = 0.0004, kNoise_rad = 0.0001;  // of a motion that was measured

// Root mean squares over all gaps of the largest errors within each.
struct Errors {
  double position = 0.0, rotation = 0.0, gaps = 0.0;
  double position_rms_m() const { return std::sqrt(position / gaps); }
  double rotation_rms() const { return std::sqrt(rotation / gaps); }
  void add(const std::vector<RigidTransform>& way, const RigidTransform* truth) {
    double most_m = 0.0, most_rad = 0.0;
    for (std::size_t k = 0; k < way.size(); ++k) {
      most_m = std::max(most_m, (way[k].t - truth[k].t).norm());
      most_rad = std::max(most_rad, (way[k].inverse() * truth[k]).angle());
    }
    position += most_m * most_m;
    rotation += most_rad * most_rad;
    gaps += 1.0;
  }
};

std::vector<RigidTransform> poses_of(const std::string& course) {
  const auto options = drivers::parse_simulator_options("course=" + course + ",frames=" + std::to_string(kFrames));
  const drivers::sim::Course way(*options);
  std::vector<RigidTransform> poses;
  for (int i = 0; i < kFrames; ++i) poses.push_back(way.T_world_camera(i));
  return poses;
}

class Gaps : public testing::TestWithParam<const char*> {};

TEST_P(Gaps, AreCrossedNoWorseThanByConstantVelocityOrByHoldingThePose) {
  const std::vector<RigidTransform> poses = poses_of(GetParam());
  constexpr TimestampNs kFrame_ns = 33'333'333;
  for (const int length : {9, 30, 60}) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    const auto noise = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)); };
    DeadReckoning reckoning{VoParams{}};
    Errors ours, constant, held;
    for (int i = 1; i + length < kFrames; ++i) {
      RigidTransform motion = poses[i - 1].inverse() * poses[i];
      motion.t += kNoise_m * noise();
      motion.R *= so3_exp(kNoise_rad * noise());
      reckoning.learn(motion, kFrame_ns);
      if (i < kKnown || i % kBetween != 0) continue;
      std::vector<RigidTransform> way, as_before;
      for (int k = 1; k <= length; ++k) {
        Vector6d variance;
        const RigidTransform& last = way.empty() ? poses[i] : way.back();
        way.push_back(last * reckoning.guess(kFrame_ns, k * kFrame_ns, variance));
        as_before.push_back((as_before.empty() ? poses[i] : as_before.back()) * motion);
      }
      ours.add(way, &poses[i + 1]);
      constant.add(as_before, &poses[i + 1]);
      held.add(std::vector<RigidTransform>(static_cast<std::size_t>(length), poses[i]), &poses[i + 1]);
    }
    const double best_m = std::min(constant.position_rms_m(), held.position_rms_m());
    EXPECT_LE(ours.position_rms_m(), kSpare * best_m + kSpare_m) << length;
    EXPECT_LE(ours.rotation_rms(), kSpare * std::min(constant.rotation_rms(), held.rotation_rms())) << length;
  }
}

INSTANTIATE_TEST_SUITE_P(Courses, Gaps, testing::Values("wheeled", "walking", "turn"),
                         [](const auto& course) { return std::string(course.param); });

}  // namespace
}  // namespace cliquevo::vo
