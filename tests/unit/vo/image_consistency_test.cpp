// SPDX-License-Identifier: BSD-3-Clause
// A motion on which all inliers agree and which the picture contradicts is reported, not published.
#include "core/vo/image_consistency.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/visual_odometry.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel{320, 240, 300.0, 300.0, 159.5, 119.5, 0.2, 0.0};

// A thing of high contrast in the rows above `split`, dull ground below; each goes sideways as it likes.
class Scene {
 public:
  Scene() {
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> frequency(-0.6, 0.6), phase(0.0, 6.28);
    for (auto& w : waves_) w = {frequency(rng), frequency(rng), phase(rng)};
  }

  // Processes the view from `ground_m` beside the ground and `thing_m` beside the thing.
  const Estimate& show(VisualOdometry& vo, int frame, int split, double ground_m, double thing_m) {
    for (auto* image : {&left_, &right_, &filtered_}) image->resize(kModel.width, kModel.height);
    disparity_.resize(kModel.width, kModel.height);
    for (int y = 0; y < kModel.height; ++y) {
      const bool thing = y < split;
      const double d = thing ? 8.0 : 20.0;
      const double shift = (thing ? thing_m : ground_m) * kModel.fx_px / kModel.depth_m(d);
      for (int x = 0; x < kModel.width; ++x) {
        const double dx = (x - kModel.cx_px) / 90.0, dy = (y - kModel.cy_px) / 70.0;
        const double light = glow_ * std::exp(-dx * dx - dy * dy);
        left_.view()(x, y) = grey(x + shift, y, thing, light);
        right_.view()(x, y) = grey(x + shift + d, y, thing, light);
        filtered_.view()(x, y) = static_cast<std::uint8_t>(left_.view()(x, y) / 4);
        disparity_.view()(x, y) = static_cast<std::int16_t>(d * kDisparityScale);
      }
    }
    const FrameInput input{frame * 100'000'000LL, left_.cview(), right_.cview(), filtered_.cview(), disparity_.cview()};
    EXPECT_TRUE(vo.process(input).ok());
    return vo.estimate();
  }

  // From now on, in the middle of both images, by so many grey levels.
  void glow(double strength) { glow_ = strength; }

  ImageView<const std::uint8_t> left() const { return left_.cview(); }
  ImageView<const std::uint8_t> right() const { return right_.cview(); }
  ImageView<const std::int16_t> disparity() const { return disparity_.cview(); }

 private:
  struct Wave {
    double fx, fy, phase;
  };
  std::uint8_t grey(double u, double v, bool thing, double light) const {
    double sum = 0.0;
    for (const Wave& w : waves_) sum += std::sin(w.fx * u + w.fy * v + w.phase + (thing ? 0.0 : 1.0));
    return static_cast<std::uint8_t>(std::lround(std::clamp(110.0 + light + (thing ? 22.0 : 2.0) * sum, 0.0, 255.0)));
  }
  Wave waves_[14];
  double glow_ = 0.0;
  Image<std::uint8_t> left_, right_, filtered_;
  Image<std::int16_t> disparity_;
};

VisualOdometry make() {
  auto made = VisualOdometry::make(kModel, {});
  EXPECT_TRUE(made.ok());
  return std::move(*made);
}

TEST(ImageConsistency, AnObjectWithAllTheCornersIsNotTheWorld) {
  Scene scene;
  VisualOdometry vo = make();
  scene.show(vo, 0, 160, 0.0, 0.0);
  for (int i = 1; i < 6; ++i) {
    const Estimate& e = scene.show(vo, i, 160, 0.1 * i, 0.01 * i);
    EXPECT_EQ(e.status, Status::ambiguous) << status_name(e.status) << " in frame " << i;
    EXPECT_GT(e.checks[Check::contradiction].value, 0.2);
  }
}

TEST(ImageConsistency, WeaklyTexturedGroundThatMovesLikewiseAgrees) {
  Scene scene;
  VisualOdometry vo = make();
  scene.show(vo, 0, 160, 0.0, 0.0);
  for (int i = 1; i < 6; ++i) {
    const Estimate& e = scene.show(vo, i, 160, 0.01 * i, 0.01 * i);
    EXPECT_EQ(e.status, Status::valid) << status_name(e.status) << " in frame " << i;
    EXPECT_LT(e.checks[Check::contradiction].value, 0.02);
    EXPECT_NEAR(e.T_world_camera.t.x(), 0.01 * i, 0.002);
  }
}

TEST(ImageConsistency, ASmallObjectDoesNotSpoilTheMotion) {
  Scene scene;
  VisualOdometry vo = make();
  scene.show(vo, 0, 222, 0.0, 0.0);  // here the larger part is the world
  for (int i = 1; i < 6; ++i) {
    const Estimate& e = scene.show(vo, i, 222, 0.08 * i, 0.01 * i);
    EXPECT_EQ(e.status, Status::valid) << status_name(e.status) << " in frame " << i;
    EXPECT_NEAR(e.T_world_camera.t.x(), 0.01 * i, 0.002);
  }
}

// Its slopes and what it burns out say nothing of how the ground moved.
TEST(ImageConsistency, AGlowThatComesAndStaysWithTheLensContradictsNothing) {
  for (const double strength : {60.0, 120.0, 200.0}) {
    Scene scene;
    VisualOdometry vo = make();
    scene.show(vo, 0, 60, 0.0, 0.0);
    scene.glow(strength);
    for (int i = 1; i < 6; ++i) {
      const Estimate& e = scene.show(vo, i, 60, 0.02 * i, 0.02 * i);
      EXPECT_EQ(e.status, Status::valid) << status_name(e.status) << " in frame " << i << ", strength " << strength;
      EXPECT_LT(e.checks[Check::contradiction].value, 0.05) << "in frame " << i << ", strength " << strength;
    }
  }
}

TEST(ImageConsistency, AFewInliersStandForTheirOwnCellsAlone) {
  Scene scene;
  VisualOdometry vo = make();
  scene.show(vo, 0, 0, 0.0, 0.0);
  const VoParams params;
  Frame frame(params);
  frame.left.copy_from(scene.left());
  frame.right.copy_from(scene.right());
  for (int y = 30; y < 220; y += 20) {
    for (int x = 40; x < 290; x += 20) {
      Feature f;
      f.x = x;
      f.y = y;
      f.disparity_px = f.raw_disparity_px = 20.0;
      frame.features.push_back(f);
    }
  }
  std::vector<Observation> observations(3);
  for (std::size_t i = 0; i < observations.size(); ++i) observations[i].feature = static_cast<int>(40 * i);
  ImageConsistency consistency(kModel);
  const SelfCheck check(kModel, params);
  consistency.choose_test_patches(scene.disparity(), frame);
  const CellVotes votes = consistency.count(frame, frame, scene.disparity(), RigidTransform{}, ViewErrors{check},
                                            observations, ImageConsistency::Contradicts::unique);
  EXPECT_EQ(votes.inliers, 3);
  EXPECT_GT(votes.agree, 20) << "the rest of the picture agrees";
  EXPECT_NEAR(votes.coverage(), 3.0 / votes.cells, 1e-12) << "and yet the motion rests on three places";
}

}  // namespace
}  // namespace cliquevo::vo
