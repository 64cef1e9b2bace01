// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/rectified_size.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"

namespace cliquevo::daemon {
namespace {

constexpr std::int64_t kFiveMegapixels = 2448 * 2048;
constexpr double kBudgetMs = 23.3;

// A machine that takes so long for a native frame, and the scales it measured.
struct Machine {
  double native_ms = 0.0;
  double fixed_ms = 0.0;  // of a frame whatever its size
  std::vector<double> asked;
  RectifiedSize pick(std::int64_t pixels) {
    auto picked = pick_scale(pixels, kBudgetMs, [this](double scale) -> Result<double> {
      asked.push_back(scale);
      return fixed_ms + (native_ms - fixed_ms) * scale * scale;
    });
    EXPECT_TRUE(picked.ok());
    return *picked;
  }
};

TEST(RectifiedSize, TheNativeSizeStaysWhereTheRateIsKept) {
  Machine fast{20.0, 0.0, {}};
  for (const std::int64_t pixels : {std::int64_t{512 * 384}, kFiveMegapixels}) {
    const RectifiedSize size = fast.pick(pixels);
    EXPECT_EQ(size.scale, 1.0);
    EXPECT_TRUE(size.fits);
    EXPECT_NEAR(size.cost_ms, 20.0, 1e-9);
  }
}

TEST(RectifiedSize, ElseItIsTheLargestThatKeepsIt) {
  Machine slow{90.0, 0.0, {}};
  const RectifiedSize size = slow.pick(kFiveMegapixels);
  EXPECT_EQ(size.scale, 0.5);  // 22.5 ms; the next, 0.625, would take 35
  EXPECT_TRUE(size.fits);
  EXPECT_NEAR(size.cost_ms, 22.5, 1e-9);
  EXPECT_NEAR(size.native_cost_ms, 90.0, 1.0);
  for (const double scale : slow.asked) EXPECT_LT(scale, 0.6) << "measured though it cannot fit";
}

TEST(RectifiedSize, WhatASmallSizeSeemsToPromiseIsMeasuredBeforeItIsTaken) {
  Machine with_overhead{30.0, -4.0, {}};  // small sizes cost less than their share: caches
  const RectifiedSize size = with_overhead.pick(kFiveMegapixels);
  EXPECT_EQ(size.scale, 0.85);
  EXPECT_LE(size.cost_ms, kBudgetMs);
  EXPECT_EQ(std::count(with_overhead.asked.begin(), with_overhead.asked.end(), size.scale), 1);
}

TEST(RectifiedSize, WhereNoSizeKeepsItTheSmallestIsTakenAndSaid) {
  Machine hopeless{40'000.0, 0.0, {}};
  const RectifiedSize size = hopeless.pick(512 * 384);
  EXPECT_FALSE(size.fits);
  EXPECT_EQ(size.scale, 0.1);
  drivers::SourceInfo info;
  info.width = 512;
  info.height = 384;
  EXPECT_NE(describe(size, info).find("does not keep the rate"), std::string::npos) << describe(size, info);
}

TEST(RectifiedSize, AnErrorOfTheMeasurementIsHandedOn) {
  const auto picked = pick_scale(kFiveMegapixels, kBudgetMs, [](double) -> Result<double> {
    return Error{"no memory", "here", "buy some"};
  });
  EXPECT_FALSE(picked.ok());
}

// Replays and recordings played as fast as possible do not depend on the machine.
TEST(RectifiedSize, NothingIsMeasuredWhereNobodyWaits) {
  Config config = default_config();
  drivers::SourceInfo info;
  info.width = 64;
  info.height = 48;
  info.rate_hz = 30.0;
  config.source.speed = 0.0;
  const auto native = choose_rectified_size(config, info);
  ASSERT_TRUE(native.ok());
  EXPECT_FALSE(native->measured);
  EXPECT_EQ(native->scale, 1.0);
  EXPECT_EQ(describe(*native, info), "");
  config.source.speed = 1.0;
  config.rectify.scale = 0.5;
  const auto given = choose_rectified_size(config, info);
  ASSERT_TRUE(given.ok());
  EXPECT_FALSE(given->measured);
  EXPECT_EQ(given->scale, 0.5);
}

TEST(RectifiedSize, ARealMeasurementEndsAndNamesWhatItFound) {
  Config config = default_config();
  drivers::SourceInfo info;
  info.width = 320;
  info.height = 240;
  info.rate_hz = 1.0;  // kept by any machine
  info.calibration.rectified = true;
  info.calibration.left.width = info.calibration.right.width = 320;
  info.calibration.left.height = info.calibration.right.height = 240;
  info.calibration.prescribed.emplace();
  info.calibration.prescribed->model = {320, 240, 350.0, 350.0, 159.5, 119.5, 0.12, 0.0};
  const auto size = choose_rectified_size(config, info);
  ASSERT_TRUE(size.ok()) << size.error().line();
  EXPECT_TRUE(size->measured);
  EXPECT_EQ(size->scale, 1.0);
  EXPECT_GT(size->cost_ms, 0.0);
  EXPECT_NE(describe(*size, info).find("native size 320x240"), std::string::npos) << describe(*size, info);
}

// The way that was driven does not depend on the size, be the images rectified here or before.
TEST(RectifiedSize, RawAndRectifiedPairsAreFollowedAtHalfTheSize) {
  for (const bool raw : {false, true}) {
    drivers::SimulatorOptions options;
    options.width = 640;
    options.height = 480;
    options.focal_px = 700.0;
    options.frames = 5;
    options.raw = raw;
    options.cache_dir = "none";
    auto source = drivers::open_simulator(options);
    ASSERT_TRUE(source.ok()) << source.error().line();
    PipelineParams params;
    params.rectify.scale = 0.5;
    auto pipeline = FramePipeline::make(params, (*source)->info());
    ASSERT_TRUE(pipeline.ok()) << pipeline.error().line();
    EXPECT_EQ(pipeline->model().width, 320);
    EXPECT_EQ(pipeline->model().height, 240);
    EXPECT_EQ(pipeline->rectified_left().width, 320);
    drivers::StereoPair pair;
    std::optional<RigidTransform> T_first_world;
    RigidTransform truth;
    while (true) {
      const auto more = (*source)->next(pair);
      ASSERT_TRUE(more.ok());
      if (!*more) break;
      ASSERT_TRUE(pipeline->process(pair).ok());
      if (!T_first_world) T_first_world = pair.truth_T_world_camera->inverse();
      truth = *T_first_world * *pair.truth_T_world_camera;
    }
    EXPECT_GT(truth.t.norm(), 0.3);
    EXPECT_LT((pipeline->estimate().T_world_camera.t - truth.t).norm(), 0.01 * truth.t.norm()) << (raw ? "raw" : "");
  }
}

}  // namespace
}  // namespace cliquevo::daemon
