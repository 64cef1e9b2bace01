// SPDX-License-Identifier: BSD-3-Clause
// Features that are looked for where a motion puts them, and what the two images of one moment show.
#include "core/vo/tracking.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/vo/seen_features.h"
#include "tests/unit/vo/walls.h"

namespace cliquevo::vo {
namespace {

const StereoModel kModel = Walls::model();

// A frame of these views with features on a grid, clear of where the walls meet.
Frame frame_of(const Walls::Views& views, double disparity_error_px = 0.0) {
  Frame frame{VoParams{}};
  frame.left.copy_from(views.left.cview());
  frame.right.copy_from(views.right.cview());
  for (int y = 20; y < 230; y += 15) {
    if (std::abs(y - 120) < 15) continue;
    for (int x = 45; x < 300; x += 15) {
      Feature f;
      f.x = x;
      f.y = y;
      f.disparity_px = f.raw_disparity_px = Walls::disparity_px(y) + disparity_error_px;
      f.point = kModel.triangulate(x, y, f.disparity_px);
      frame.features.push_back(f);
    }
  }
  return frame;
}

struct Tracking {
  SelfCheck check{kModel, {}};
  Tracker tracker{kModel, {}};
  std::vector<Observation> observations;

  void track(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur,
             const FeatureRange& range = {}) {
    observations.clear();
    tracker.track(reference, current, T_ref_cur, 0, range, PatchSize::usual, {check}, observations);
  }
};

RigidTransform sideways(double x_m, double y_m) {
  RigidTransform T;
  T.t = {x_m, y_m, 0.0};
  return T;
}

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

TEST(Slant, IsThatOfThePlaneAroundTheFeature) {
  Image<std::int16_t> disparity(40, 40);
  Feature f;
  f.x = f.y = 20;
  const auto fill = [&](double dx, double dy) {
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 40; ++x) {
        disparity.view()(x, y) =
            static_cast<std::int16_t>(std::lround(kDisparityScale * (20.0 + dx * (x - 20) + dy * (y - 20))));
      }
    }
  };
  fill(0.15, -0.05);
  measure_slant(disparity.cview(), f);
  EXPECT_NEAR(f.disparity_dx, 0.15, 0.01);
  EXPECT_NEAR(f.disparity_dy, -0.05, 0.01);
  // What belongs to another surface does not count, nor do unknown places.
  for (int y = 0; y < 40; ++y) {
    for (int x = 23; x < 40; ++x) disparity.view()(x, y) = 40 * kDisparityScale;
    disparity.view()(16, y) = kUnknownDisparity;
  }
  measure_slant(disparity.cview(), f);
  EXPECT_NEAR(f.disparity_dx, 0.15, 0.02);
  EXPECT_NEAR(f.disparity_dy, -0.05, 0.02);
  disparity.fill(kUnknownDisparity);
  disparity.view()(20, 20) = 20 * kDisparityScale;
  measure_slant(disparity.cview(), f);
  EXPECT_EQ(f.disparity_dx, 0.0) << "too little is known";
}

TEST(Tracker, FindsFeaturesWhereTheyAreNow) {
  const Walls walls;
  const Frame reference = frame_of(walls.from(0.0, 0.0));
  const Frame current = frame_of(walls.from(0.031, -0.012));
  Tracking t;
  t.track(reference, current, sideways(0.03, -0.01));  // not quite where they are
  ASSERT_GT(t.observations.size(), reference.features.size() * 3 / 4);
  std::vector<double> off_px, off_disparity_px;
  for (const Observation& o : t.observations) {
    const double px_per_m = kModel.fx_px / kModel.depth_m(Walls::disparity_px(o.uvd_ref.y()));
    off_px.push_back(std::hypot(o.uvd_cur.x() - (o.uvd_ref.x() - 0.031 * px_per_m),
                                o.uvd_cur.y() - (o.uvd_ref.y() + 0.012 * px_per_m)));
    off_disparity_px.push_back(std::abs(o.uvd_cur.z() - Walls::disparity_px(o.uvd_ref.y())));
    EXPECT_LT(o.change, 0.2F);
  }
  EXPECT_LT(median_of(off_px), 0.1);
  EXPECT_LT(median_of(off_disparity_px), 0.1);
}

TEST(Tracker, LooksForTheNamedFeaturesAlone) {
  const Walls walls;
  const Frame frame = frame_of(walls.from(0.0, 0.0));
  Tracking t;
  t.track(frame, frame, {}, {.first = 10, .last = 25});
  ASSERT_FALSE(t.observations.empty());
  for (const Observation& o : t.observations) {
    EXPECT_GE(o.feature, 10);
    EXPECT_LT(o.feature, 25);
  }
}

TEST(Tracker, FindsHardlyAnythingWhereTheMotionIsAnotherOrTheWorldIs) {
  const Walls walls;
  const Frame reference = frame_of(walls.from(0.0, 0.0));
  const Frame current = frame_of(walls.from(0.03, 0.0));
  Tracking t;
  t.track(reference, current, sideways(0.5, 0.0));
  EXPECT_LT(t.observations.size(), reference.features.size() / 10);
  t.track(reference, frame_of(Walls(2).from(0.0, 0.0)), {});
  EXPECT_LT(t.observations.size(), reference.features.size() / 10);
}

TEST(Tracker, NoiseThatTheCameraIsKnownToHaveDoesNotHideFeatures) {
  const Walls walls;
  const Frame reference = frame_of(walls.from(0.0, 0.0));
  Walls::Views views = walls.from(0.0, 0.0);
  std::mt19937 rng(1);
  std::normal_distribution<double> noise(0.0, 35.0);
  for (Image<std::uint8_t>* image : {&views.left, &views.right}) {
    for (int y = 0; y < image->height(); ++y) {
      for (int x = 0; x < image->width(); ++x) {
        std::uint8_t& p = image->view()(x, y);
        p = static_cast<std::uint8_t>(std::clamp(p + noise(rng), 0.0, 255.0));
      }
    }
  }
  const Frame noisy = frame_of(views);
  Tracking t;
  t.tracker.set_noise(1.0);
  t.track(reference, noisy, {});
  const std::size_t of_a_clean_camera = t.observations.size();
  t.tracker.set_noise(30.0);
  t.track(reference, noisy, {});
  EXPECT_GT(t.observations.size(), of_a_clean_camera * 6 / 5);
}

TEST(Tracker, BringsTheMatchersDisparitiesToAFractionOfAPixel) {
  const Walls walls;
  Frame frame = frame_of(walls.from(0.0, 0.0), 0.6);
  Tracking t;
  t.tracker.refine_disparities({t.check}, frame);
  std::vector<double> off_px;
  for (const Feature& f : frame.features) {
    off_px.push_back(std::abs(f.disparity_px - Walls::disparity_px(f.y)));
    EXPECT_NEAR((kModel.project(f.point) - Eigen::Vector3d(f.x, f.y, f.disparity_px)).norm(), 0.0, 1e-9);
  }
  EXPECT_LT(median_of(off_px), 0.05);
}

TEST(Tracker, MeasuresARightImageThatSitsLower) {
  const Walls walls;
  Tracking t;
  Frame straight = frame_of(walls.from(0.0, 0.0));
  const Walls::Views views = walls.from({.right_lower_px = 0.6});
  Frame lower = frame_of(views);
  t.tracker.measure_views(views.disparity.cview(), t.check, straight);
  EXPECT_NEAR(straight.row_shift_px, 0.0, 0.02);
  EXPECT_LT(straight.row_scatter_px, 0.1);
  EXPECT_LT(straight.grey_scatter, 4.0);
  Tracking other;
  other.tracker.measure_views(views.disparity.cview(), other.check, lower);
  EXPECT_NEAR(lower.row_shift_px, 0.6, 0.03);
  EXPECT_NEAR(other.check.vertical_error_px(kModel.cx_px, kModel.cy_px), 0.6, 0.05) << "the self-check learns it";
}

TEST(Tracker, TakesOffWhatTheSelfCheckKnowsAndTheFramesOwnShift) {
  Tracking t;
  for (int i = 0; i < 200; ++i) {
    t.check.add_offset(0.4 - t.check.disparity_error_px(kModel.cx_px, kModel.cy_px), 400.0);
  }
  Frame frame{VoParams{}};
  Feature f;
  f.x = 160;
  f.y = 120;
  f.raw_disparity_px = 10.0;
  frame.features = {f};
  frame.shift_px = 0.25;
  t.tracker.compensate(t.check, frame);
  EXPECT_NEAR(frame.features[0].disparity_px, 10.0 - 0.4 - 0.25, 0.02);
  EXPECT_NEAR(frame.features[0].point.z(), kModel.depth_m(frame.features[0].disparity_px), 1e-9);
}

TEST(SeenFeatures, SayWhatBecameOfEachOne) {
  const Walls walls;
  Frame reference = frame_of(walls.from(0.0, 0.0));
  reference.features.resize(4);
  Frame current = frame_of(walls.from(0.0, 0.0));
  current.features.resize(2);
  std::vector<Observation> observations(3);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Feature& f = reference.features[i];
    observations[i].uvd_ref = observations[i].uvd_cur = {1.0 * f.x, 1.0 * f.y, f.disparity_px};
    observations[i].feature = static_cast<int>(i);
  }
  observations[1].inlier = false;
  observations[2].reference = 1;
  const RigidTransform none;
  Movers movers;
  std::vector<SeenFeature> seen;
  list_seen({kModel, &current, &reference, &observations, none, movers}, seen);
  std::vector<FeatureRole> roles;
  for (const SeenFeature& s : seen) roles.push_back(s.role);
  // The third observation is the key frame's: the reference's third and fourth feature were not found.
  EXPECT_EQ(roles, (std::vector<FeatureRole>{FeatureRole::inlier, FeatureRole::outlier, FeatureRole::of_key,
                                             FeatureRole::not_found, FeatureRole::not_found}));
  movers.count = 1;
  movers.mover[0].points = 1;
  movers.mover[0].point[0] = {50.0F, 60.0F, {0.1F, 0.1F, 3.0F}};
  list_seen({kModel, &current, nullptr, nullptr, none, movers}, seen);
  ASSERT_EQ(seen.size(), 3U) << "nothing to compare with: two corners, and the mover's point";
  EXPECT_EQ(seen[0].role, FeatureRole::corner);
  EXPECT_EQ(seen[2].role, FeatureRole::mover);
  EXPECT_NEAR(seen[2].disparity_px, 300.0 * 0.2 / 3.0, 1e-4);
}

}  // namespace
}  // namespace cliquevo::vo
