// SPDX-License-Identifier: BSD-3-Clause
// The two stages one after the other, on a short course of the simulator whose truth is known.
#include "daemon/pipeline/stages.h"

#include <memory>

#include <gtest/gtest.h>

#include "drivers/simulator.h"

namespace cliquevo::daemon {
namespace {

std::unique_ptr<drivers::Simulator> course() {
  auto options = drivers::parse_simulator_options("width=160,height=120,focal_px=175,frames=4,course=straight");
  EXPECT_TRUE(options.ok());
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  return std::move(*simulator);
}

drivers::SourceInfo copy_of(const drivers::SourceInfo& from) {
  drivers::SourceInfo out;
  out.width = from.width;
  out.height = from.height;
  out.calibration = from.calibration;
  return out;
}

TEST(Stages, PairsBecomeDisparitiesAndThoseBecomeAWay) {
  const auto source = course();
  auto stereo = StereoStage::make({}, source->info());
  ASSERT_TRUE(stereo.ok()) << stereo.error().line();
  auto odometry = OdometryStage::make({}, source->info(), *stereo);
  ASSERT_TRUE(odometry.ok()) << odometry.error().line();
  EXPECT_TRUE(odometry->mask().empty());
  EXPECT_TRUE(stereo->worker_handles().empty()) << "one worker is the caller";
  StereoFrame frame;
  stereo->prepare(frame);
  drivers::StereoPair pair;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(*source->next(pair));
    ASSERT_TRUE(stereo->run(pair, frame).ok());
    ASSERT_TRUE(odometry->run(pair.stamp_ns, frame).ok());
    EXPECT_GT(frame.times.stereo_ns, 0);
    EXPECT_GT(frame.times.odometry_ns, 0);
  }
  const vo::Estimate& e = odometry->estimate();
  ASSERT_EQ(e.status, vo::Status::valid) << vo::status_name(e.status);
  EXPECT_NEAR((e.T_world_camera.t - pair.truth_T_world_camera->t).norm(), 0.0, 0.01);
  std::vector<vo::SeenFeature> features;
  odometry->list_features(features);
  EXPECT_GE(static_cast<int>(features.size()), e.inliers);
  odometry->reset();
  ASSERT_TRUE(odometry->run(pair.stamp_ns, frame).ok());
  EXPECT_EQ(odometry->estimate().status, vo::Status::no_data);
}

TEST(Stages, WhatIsMaskedGivesNoFeatureAndNoDepth) {
  const auto source = course();
  drivers::SourceInfo info = copy_of(source->info());
  for (Image<std::uint8_t>* mask : {&info.left_mask, &info.right_mask}) {
    mask->resize(info.width, info.height);
    mask->fill(255);
    for (int y = 60; y < info.height; ++y) {
      for (int x = 0; x < info.width; ++x) mask->view()(x, y) = 0;
    }
  }
  auto stereo = StereoStage::make({}, info);
  ASSERT_TRUE(stereo.ok()) << stereo.error().line();
  auto odometry = OdometryStage::make({}, info, *stereo);
  ASSERT_TRUE(odometry.ok()) << odometry.error().line();
  EXPECT_FALSE(odometry->mask().empty());
  StereoFrame frame;
  stereo->prepare(frame);
  drivers::StereoPair pair;
  ASSERT_TRUE(*source->next(pair));
  ASSERT_TRUE(stereo->run(pair, frame).ok());
  ASSERT_TRUE(odometry->run(pair.stamp_ns, frame).ok());
  int known_below = 0, known_above = 0;
  for (int y = 0; y < info.height; ++y) {
    for (int x = 0; x < info.width; ++x) {
      const bool known = frame.disparity.view()(x, y) != kUnknownDisparity;
      (y >= 62 ? known_below : known_above) += known ? 1 : 0;
    }
  }
  // What lies left of the right image's border keeps its disparity: nothing there says that it is wrong.
  EXPECT_LT(known_below, known_above / 10);
  std::vector<vo::SeenFeature> features;
  odometry->list_features(features);
  for (const vo::SeenFeature& f : features) EXPECT_LT(f.y_px, 61.0F);
}

TEST(Stages, AnImageOfAnotherSizeIsNamedWithBoth) {
  const auto source = course();
  auto stereo = StereoStage::make({}, source->info());
  ASSERT_TRUE(stereo.ok());
  StereoFrame frame;
  stereo->prepare(frame);
  drivers::StereoPair pair;
  ASSERT_TRUE(*source->next(pair));
  pair.right.resize(80, 60);
  const auto done = stereo->run(pair, frame);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().what, "right image of another size");
  EXPECT_NE(done.error().remedy.find("80x60"), std::string::npos);
  EXPECT_NE(done.error().remedy.find("160x120"), std::string::npos);
}

TEST(Stages, ParametersThatCannotBeAreRefused) {
  const auto source = course();
  stereo::StereoParams bad;
  bad.window = 4;
  EXPECT_FALSE(StereoStage::make(bad, source->info()).ok());
  auto stereo = StereoStage::make({}, source->info());
  ASSERT_TRUE(stereo.ok());
  vo::VoParams none;
  none.max_features = 0;
  EXPECT_FALSE(OdometryStage::make(none, source->info(), *stereo).ok());
}

}  // namespace
}  // namespace cliquevo::daemon
