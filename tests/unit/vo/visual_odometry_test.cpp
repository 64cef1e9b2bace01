// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/visual_odometry.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/vo/walls.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel = Walls::model();
constexpr std::int64_t kPeriod_ns = Walls::kPeriod_ns;

VisualOdometry make(const VoParams& params = {}) {
  auto made = VisualOdometry::make(kModel, params);
  EXPECT_TRUE(made.ok());
  return std::move(*made);
}

TEST(VisualOdometry, FollowsASidewaysMotionToAFractionOfAPixel) {
  const Walls scene;
  VisualOdometry vo = make();
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(vo.process(scene.from(0.013 * i, -0.004 * i).input(i)).ok());
    const Estimate& e = vo.estimate();
    EXPECT_EQ(e.status, i == 0 ? Status::no_data : Status::valid) << status_name(e.status) << " in frame " << i;
    // 1 mm is 0.04 px on the nearer wall
    EXPECT_NEAR((e.T_world_camera.t - Eigen::Vector3d(0.013 * i, -0.004 * i, 0.0)).norm(), 0.0, 0.002) << i;
    EXPECT_LT(e.T_world_camera.angle(), 0.0005);
    EXPECT_TRUE(e.covariance.allFinite());
  }
}

TEST(VisualOdometry, StandsStillThroughAnExposureChange) {
  const Walls scene;
  VisualOdometry vo = make();
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(vo.process(scene.from(0.0, 0.0, i < 5 ? 1.0 : 0.8).input(i)).ok());
    if (i > 0) {
      EXPECT_EQ(vo.estimate().status, Status::valid) << i;
    }
  }
  EXPECT_LT(vo.estimate().T_world_camera.t.norm(), 0.0005);
}

TEST(VisualOdometry, ReportsABlindFrameAndBridgesIt) {
  const Walls scene;
  VisualOdometry vo = make();
  ASSERT_TRUE(vo.process(scene.from(0.0, 0.0).input(0)).ok());
  ASSERT_TRUE(vo.process(scene.from(0.01, 0.0).input(1)).ok());
  Walls::Views blank = scene.from(0.0, 0.0);
  blank.left.fill(90);
  blank.right.fill(90);
  blank.filtered.fill(31);
  ASSERT_TRUE(vo.process(blank.input(2)).ok());
  EXPECT_EQ(vo.estimate().status, Status::too_few_features);
  EXPECT_EQ(vo.estimate().T_prev_cur.t.norm(), 0.0);
  EXPECT_TRUE(vo.estimate().covariance.allFinite());
  EXPECT_NEAR(vo.estimate().T_world_camera.t.x(), 0.02, 0.002) << "constant velocity is the stated guess";
  ASSERT_TRUE(vo.process(scene.from(0.03, 0.0).input(3)).ok());
  const Estimate& e = vo.estimate();
  EXPECT_EQ(e.status, Status::valid);
  EXPECT_EQ(e.prev_stamp_ns, 1 * kPeriod_ns) << "the delta spans the gap";
  EXPECT_NEAR(e.T_prev_cur.t.x(), 0.02, 0.002);
  EXPECT_NEAR(e.T_world_camera.t.x(), 0.03, 0.002);
}

TEST(VisualOdometry, AnotherWorldIsAFailureNotAMotion) {
  VisualOdometry vo = make();
  ASSERT_TRUE(vo.process(Walls(1).from(0.0, 0.0).input(0)).ok());
  ASSERT_TRUE(vo.process(Walls(2).from(0.0, 0.0).input(1)).ok());
  EXPECT_NE(vo.estimate().status, Status::valid);
}

TEST(VisualOdometry, RefusesUnusableInputAndStaysAsItWas) {
  const Walls scene;
  VisualOdometry vo = make();
  ASSERT_TRUE(vo.process(scene.from(0.0, 0.0).input(0)).ok());
  ASSERT_TRUE(vo.process(scene.from(0.01, 0.0).input(1)).ok());
  const Estimate before = vo.estimate();
  const Walls::Views good = scene.from(0.02, 0.0);
  FrameInput no_right = good.input(2);
  no_right.right = {};
  EXPECT_FALSE(vo.process(no_right).ok());
  FrameInput small = good.input(2);
  small.left.width = 100;
  EXPECT_FALSE(vo.process(small).ok());
  EXPECT_FALSE(vo.process(good.input(1)).ok()) << "a stamp that does not advance";
  EXPECT_EQ(vo.estimate().stamp_ns, before.stamp_ns);
  ASSERT_TRUE(vo.process(good.input(2)).ok());
  EXPECT_EQ(vo.estimate().status, Status::valid);
  EXPECT_NEAR(vo.estimate().T_world_camera.t.x(), 0.02, 0.002);
}

TEST(VisualOdometry, NamesWhatIsWrongWithItsInputAndStaysAsItWas) {
  const Walls scene;
  VisualOdometry vo = make();
  ASSERT_TRUE(vo.process(scene.from(0.0, 0.0).input(0)).ok());
  ASSERT_TRUE(vo.process(scene.from(0.01, 0.0).input(1)).ok());
  const Estimate before = vo.estimate();
  const Walls::Views good = scene.from(0.02, 0.0);
  std::vector<FrameInput> bad(6, good.input(2));
  bad[0].left = {};
  bad[1].right = {};
  bad[2].filtered_left = {};
  bad[3].disparity = {};
  bad[4].disparity.height = 17;
  bad[5].stamp_ns = -5;
  for (const FrameInput& input : bad) {
    const Result<void> refused = vo.process(input);
    ASSERT_FALSE(refused.ok());
    EXPECT_FALSE(refused.error().what.empty() || refused.error().where.empty() || refused.error().remedy.empty());
    EXPECT_EQ(vo.estimate().stamp_ns, before.stamp_ns);
    EXPECT_EQ(vo.estimate().T_world_camera.t, before.T_world_camera.t);
  }
  for (double StereoModel::*member : {&StereoModel::fx_px, &StereoModel::fy_px, &StereoModel::baseline_m}) {
    for (const double value : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
      StereoModel impossible = kModel;
      impossible.*member = value;
      EXPECT_FALSE(VisualOdometry::make(impossible, {}).ok()) << value;
    }
  }
  // Features without disparity are no features: a verdict, not an error.
  Walls::Views flat = scene.from(0.02, 0.0);
  flat.disparity.fill(kUnknownDisparity);
  ASSERT_TRUE(vo.process(flat.input(2)).ok());
  EXPECT_EQ(vo.estimate().features, 0);
  EXPECT_EQ(vo.estimate().status, Status::too_few_features);
  ASSERT_TRUE(vo.process(scene.from(0.03, 0.0).input(3)).ok());
  EXPECT_EQ(vo.estimate().status, Status::valid);
  EXPECT_NEAR(vo.estimate().T_world_camera.t.x(), 0.03, 0.002);
}

TEST(VisualOdometry, AMaskKeepsFeaturesAway) {
  const Walls scene;
  VisualOdometry vo = make();
  Image<std::uint8_t> mask(kModel.width, kModel.height);
  mask.fill(0);
  ASSERT_TRUE(vo.set_mask(mask.cview()).ok());
  ASSERT_TRUE(vo.process(scene.from(0.0, 0.0).input(0)).ok());
  EXPECT_EQ(vo.estimate().features, 0);
  EXPECT_FALSE(
      vo.set_mask(mask.cview().empty() ? mask.cview() : ImageView<const std::uint8_t>(mask.cview().data, 9, 9, 9))
          .ok());
}

// Something near in the lower half that goes where the camera goes: bright spots on dark tiles, no two alike.
void put_vehicle_part(Walls::Views& v) {
  constexpr int kDisparity = 40;
  constexpr int kTile = 10;
  for (int row = 150; row < 220; ++row) {
    for (int column = 120; column < 220; ++column) {
      std::mt19937 rng(static_cast<unsigned>(1000 * (row / kTile) + column / kTile));
      const int dark = 30 + static_cast<int>(rng() % 60), bright = 150 + static_cast<int>(rng() % 90);
      const int x = 1 + static_cast<int>(rng() % 4), y = 1 + static_cast<int>(rng() % 4);
      const int dx = column % kTile - x, dy = row % kTile - y;
      const bool spot = dx >= 0 && dx < 4 && dy >= 0 && dy < 4;
      const auto grey = static_cast<std::uint8_t>(spot ? bright : dark);
      v.left.view()(column, row) = grey;
      v.right.view()(column - kDisparity, row) = grey;
      v.filtered.view()(column, row) = static_cast<std::uint8_t>(grey / 4);
      v.disparity.view()(column, row) = kDisparity * kDisparityScale;
    }
  }
}

TEST(VisualOdometry, DetectsAPartOfTheVehicleInTheView) {
  Walls::Views here = Walls().from(0.0, 0.0), there = Walls().from(0.03, 0.01);
  put_vehicle_part(here);
  put_vehicle_part(there);
  VisualOdometry vo = make();
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(vo.process((i % 2 == 0 ? here : there).input(i)).ok());
    if (i < 20) {
      EXPECT_EQ(vo.estimate().vehicle_part.frames, 0) << i;
    }
  }
  const VehiclePart& part = vo.estimate().vehicle_part;
  ASSERT_GT(part.frames, 5);
  EXPECT_GE(part.left_px, 120.0);
  EXPECT_LE(part.right_px, 220.0);
  EXPECT_GE(part.top_px, 150.0);
  EXPECT_LE(part.bottom_px, 220.0);
}

TEST(VisualOdometry, ResetStartsAgainAtTheIdentity) {
  const Walls scene;
  VisualOdometry vo = make();
  ASSERT_TRUE(vo.process(scene.from(0.0, 0.0).input(0)).ok());
  ASSERT_TRUE(vo.process(scene.from(0.05, 0.0).input(1)).ok());
  vo.reset();
  ASSERT_TRUE(vo.process(scene.from(0.1, 0.0).input(2)).ok());
  EXPECT_EQ(vo.estimate().status, Status::no_data);
  EXPECT_EQ(vo.estimate().T_world_camera.t.norm(), 0.0);
}

TEST(VisualOdometry, NamesAnImpossibleModelOrParameter) {
  StereoModel model = kModel;
  model.baseline_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(VisualOdometry::make(model, {}).ok());
  VoParams params;
  params.descriptor_window = 8;
  const auto made = VisualOdometry::make(kModel, params);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().where, "descriptor_window");
}

}  // namespace
}  // namespace cliquevo::vo
