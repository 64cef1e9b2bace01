// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/clique.h"
#include "core/vo/mover_tracker.h"
#include "core/vo/other_motions.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{512, 384, 560.0, 560.0, 255.5, 191.5, 0.12, 0.0};
constexpr std::int64_t kPeriodNs = 33'333'333;
constexpr double kPeriodS = 1e-9 * kPeriodNs;

RigidTransform moved(double x, double y, double z, double turn = 0.0) {
  RigidTransform T;
  T.R = so3_exp({0.0, turn, 0.0});
  T.t = {x, y, z};
  return T;
}

// Points of the world, of a thing, and matches that are simply wrong, as two frames would have them: every point keeps
// its index, its pixel is a whole one, its disparity that of the pixel.
class Stage {
 public:
  explicit Stage(unsigned seed) : rng_(seed) {}

  void add_world(int count) {
    std::uniform_real_distribution<double> x(-2.5, 2.5), y(-1.2, 1.0), z(3.0, 12.0);
    for (int i = 0; i < count; ++i) world_.push_back({x(rng_), y(rng_), z(rng_)});
  }
  // Around a place in the first camera's frame.
  void add_thing(const Eigen::Vector3d& place, int count) {
    std::uniform_real_distribution<double> side(-0.4, 0.4);
    for (int i = 0; i < count; ++i) thing_.push_back(place + Eigen::Vector3d(side(rng_), side(rng_), side(rng_)));
  }
  void add_false_matches(int count) { false_matches_ = count; }

  Frame frame(int index, const RigidTransform& T_world_camera, const RigidTransform& T_world_thing) {
    Frame f(VoParams{});
    f.stamp_ns = index * kPeriodNs;
    f.T_world_camera = T_world_camera;
    const RigidTransform T_camera_world = T_world_camera.inverse();
    for (const Eigen::Vector3d& p : world_) f.features.push_back(feature(T_camera_world * p));
    for (const Eigen::Vector3d& p : thing_) f.features.push_back(feature(T_camera_world * (T_world_thing * p)));
    std::uniform_real_distribution<double> x(-2.0, 2.0), y(-1.0, 1.0), z(2.0, 20.0);
    for (int i = 0; i < false_matches_; ++i) f.features.push_back(feature({x(rng_), y(rng_), z(rng_)}));
    return f;
  }

 private:
  Feature feature(const Eigen::Vector3d& p) {
    std::normal_distribution<double> noise(0.0, 0.1);
    Feature f;
    f.x = static_cast<int>(std::lround(kModel.fx_px * p.x() / p.z() + kModel.cx_px));
    f.y = static_cast<int>(std::lround(kModel.fy_px * p.y() / p.z() + kModel.cy_px));
    f.disparity_px = kModel.fx_px * kModel.baseline_m / p.z() + noise(rng_);
    f.point = kModel.triangulate(f.x, f.y, f.disparity_px);
    return f;
  }

  std::mt19937 rng_;
  std::vector<Eigen::Vector3d> world_, thing_;
  int false_matches_ = 0;
};

// The odometry's steps around the movers, without pictures.
class MoversTest : public testing::Test {
 protected:
  void step(const Frame& reference, const Frame& current, bool valid = true) {
    std::vector<Match> matches;
    std::vector<PointPair> pairs;
    for (std::size_t i = 0; i < current.features.size(); ++i) {
      const int k = static_cast<int>(i);
      matches.push_back({k, k, 0});
      pairs.push_back({reference.features[i].point, current.features[i].point});
    }
    std::vector<int> clique;
    cliques_.find(pairs, clique);
    Motion first;
    first.T_prev_cur = reference.T_world_camera.inverse() * current.T_world_camera;
    first.covariance = 1e-6 * Matrix6d::Identity();
    finder_.find(reference, current, matches, pairs, first, cliques_, solver_, others_);
    tracker_.update(reference, current, others_, first.T_prev_cur, valid);
  }
  const Movers& movers() const { return tracker_.movers(); }

  VoParams params_;
  CliqueFinder cliques_{kModel, params_};
  MotionSolver solver_{kModel, params_};
  OtherMotionFinder finder_{params_};
  OtherMotions others_{8, static_cast<std::size_t>(params_.max_features)};
  MoverTracker tracker_{kModel, params_};
};

TEST_F(MoversTest, AnObjectThatMovesByItselfIsPublishedWithItsVelocityUnderOneNumber) {
  Stage stage(1);
  stage.add_world(150);
  stage.add_thing({0.3, 0.2, 4.0}, 25);
  stage.add_false_matches(40);
  // Ahead of the camera and across, 3 m/s; the camera drives at 2 m/s and turns.
  const Eigen::Vector3d velocity(3.0, 0.0, 0.5);
  std::vector<Frame> frames;
  for (int i = 0; i < 12; ++i) {
    RigidTransform T_world_thing;
    T_world_thing.t = i * kPeriodS * velocity;
    frames.push_back(stage.frame(i, moved(0.0, 0.0, 2.0 * i * kPeriodS, 0.003 * i), T_world_thing));
  }
  int id = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    step(frames[i - 1], frames[i]);
    ASSERT_EQ(movers().count, i < 3 ? 0 : 1) << "frame " << i;
    if (i < 3) continue;
    const Mover& m = movers().mover[0];
    if (id == 0) id = m.id;
    EXPECT_EQ(m.id, id);
    EXPECT_EQ(m.frames, static_cast<int>(i));
    EXPECT_FALSE(m.of_vehicle);
    EXPECT_GE(m.inliers, 15);
    EXPECT_EQ(m.points, m.inliers);
    const Eigen::Vector3d seen = frames[i].T_world_camera.R * m.velocity_m_s;
    EXPECT_NEAR((seen - velocity).norm(), 0.0, 0.6)
        << seen.transpose();  // a tenth of a pixel of disparity is 0.7 m/s of one point
    const Eigen::Vector3d truth = frames[i].T_world_camera.inverse() *
                                  (Eigen::Vector3d(0.3, 0.2, 4.0) + static_cast<double>(i) * kPeriodS * velocity);
    EXPECT_NEAR((m.centre - truth).norm(), 0.0, 0.3);
  }
  EXPECT_EQ(tracker_.vehicle_part().frames, 0);
}

TEST_F(MoversTest, FalseMatchesAreNoThing) {
  Stage stage(2);
  stage.add_world(150);
  stage.add_false_matches(80);
  Frame last = stage.frame(0, {}, {});
  int published = 0;
  for (int i = 1; i < 60; ++i) {
    Frame next = stage.frame(i, moved(0.0, 0.0, 0.07 * i), {});
    step(last, next);
    published += movers().count;
    last = std::move(next);
  }
  EXPECT_EQ(published, 0);
}

TEST_F(MoversTest, APartOfTheVehicleIsDetectedWithItsPlace) {
  Stage stage(3);
  stage.add_world(150);
  stage.add_thing({0.2, 0.5, 1.6}, 20);
  Frame last = stage.frame(0, {}, {});
  for (int i = 1; i < 50; ++i) {
    const RigidTransform T = moved(0.0, 0.0, 0.1 * i, 0.002 * i);
    Frame next = stage.frame(i, T, T);  // it goes where the camera goes
    step(last, next, i % 2 == 0);       // found whatever the verdict
    last = std::move(next);
  }
  const VehiclePart& part = tracker_.vehicle_part();
  EXPECT_GE(part.frames, 10);
  EXPECT_NEAR(part.left_px, 255.5 + 560.0 * -0.2 / 1.6, 60.0);
  EXPECT_NEAR(part.right_px, 255.5 + 560.0 * 0.6 / 1.6, 60.0);
  EXPECT_NE(describe(part).find("mask"), std::string::npos);
  tracker_.reset();
  EXPECT_EQ(tracker_.vehicle_part().frames, 0);
}

TEST_F(MoversTest, AVehicleAheadAtTheSamePaceIsNoPartOfOurs) {
  Stage stage(4);
  stage.add_world(150);
  stage.add_thing({0.0, 0.0, 3.0}, 30);
  Frame last = stage.frame(0, {}, {});
  for (int i = 1; i < 90; ++i) {
    const RigidTransform T = moved(0.0, 0.0, 0.1 * i);
    RigidTransform ahead = T;  // it keeps its distance to a hand's breadth
    ahead.t += Eigen::Vector3d(0.04 * std::sin(0.11 * i), 0.0, 0.1 * std::sin(0.07 * i));
    Frame next = stage.frame(i, T, ahead);
    step(last, next);
    last = std::move(next);
  }
  EXPECT_EQ(tracker_.vehicle_part().frames, 0);
  EXPECT_EQ(movers().count, 1);
}

TEST_F(MoversTest, NothingIsPublishedOfAFailedFrame) {
  Stage stage(5);
  stage.add_world(150);
  stage.add_thing({0.3, 0.2, 4.0}, 25);
  Frame last = stage.frame(0, {}, {});
  for (int i = 1; i < 8; ++i) {
    Frame next = stage.frame(i, moved(0.0, 0.0, 0.07 * i), moved(0.1 * i, 0.0, 0.0));
    step(last, next, i != 7);
    if (i == 6) {
      EXPECT_EQ(movers().count, 1);
    }
    last = std::move(next);
  }
  EXPECT_EQ(movers().count, 0);
  EXPECT_EQ(movers().stamp_ns, 7 * kPeriodNs);
}

}  // namespace
}  // namespace cliquevo::vo
