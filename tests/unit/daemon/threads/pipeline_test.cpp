// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline.h"

#include <atomic>
#include <memory>

#include <gtest/gtest.h>

#include "tests/unit/daemon/threads/pipeline_bench.h"

namespace cliquevo::daemon {
namespace {

using test::Bench;
using test::Counter;
using test::expect_consistent;
using test::kSecondNs;
using test::nap_ms;

TEST(Pipeline, WithoutAPaceEveryFrameGoesThroughHoweverSlowAStageIs) {
  for (const int slow : {0, 1, 2}) {
    Bench bench;
    (slow == 0 ? bench.stereo_ms : slow == 1 ? bench.odometry_ms : bench.output_ms) = 0.5;
    auto pipeline = Pipeline::start({.speed = 0.0}, bench, std::make_unique<Counter>(400, 10.0));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
    EXPECT_TRUE(pipeline->outcome().ok());
    ASSERT_EQ(bench.out.size(), 400u);
    for (std::size_t i = 0; i < 400; ++i) EXPECT_EQ(bench.out[i].index, static_cast<std::int64_t>(i));
    expect_consistent(bench, pipeline->counts());
    EXPECT_EQ(pipeline->counts().dropped, 0);
  }
}

TEST(Pipeline, UnderOverloadTheNewestFrameIsTakenAndTheOthersAreCounted) {
  static constexpr std::int64_t kFrames = 300;
  for (const bool stereo_is_slow : {true, false}) {
    Bench bench;
    auto source = std::make_unique<Counter>(kFrames, 1.0);
    const Counter& counter = *source;
    // The slow stage lets ten frames pass by with each one that it takes.
    const auto dawdle = [&counter](const FrameSlot& slot) {
      while (counter.given < std::min(slot.pair.index + 10, kFrames)) nap_ms(0.2);
    };
    (stereo_is_slow ? bench.in_stereo : bench.in_odometry) = dawdle;
    auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::move(source));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
    const PipelineCounts counts = pipeline->counts();
    EXPECT_EQ(counts.grabbed, kFrames);
    EXPECT_GT(counts.dropped, kFrames / 2);
    EXPECT_GT(counts.published, 3);
    expect_consistent(bench, counts);
    EXPECT_EQ(bench.out.back().index, kFrames - 1) << "the newest is never skipped, so the last one arrives";
  }
}

// The stage stands still once, for a few frames, and is quick otherwise.
TEST(Pipeline, AHiccupOfAStageLosesNoFrame) {
  static constexpr std::int64_t kFrames = 24;
  static constexpr std::int64_t kAt = 12;
  for (const bool stereo_hiccups : {true, false}) {
    Bench bench;
    auto source = std::make_unique<Counter>(kFrames, 50.0);
    const Counter& counter = *source;
    (stereo_hiccups ? bench.in_stereo : bench.in_odometry) = [&counter](const FrameSlot& slot) {
      // Until three more are given at least; the fourth is being waited for then.
      while (slot.pair.index == kAt && counter.given < kAt + 5) nap_ms(0.2);
    };
    auto pipeline = Pipeline::start({.speed = 1.0, .catch_up_frames = 15}, bench, std::move(source));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
    expect_consistent(bench, pipeline->counts());
    EXPECT_EQ(pipeline->counts().dropped, 0);
    EXPECT_EQ(pipeline->counts().published, kFrames);
  }
}

// 4000 x 4000 px take 112 MB a frame: none may wait.
TEST(Pipeline, OfLargeImagesNoMoreWaitThanMemoryAllows) {
  static constexpr std::int64_t kFrames = 24;
  Bench bench;
  auto source = std::make_unique<Counter>(kFrames, 20.0, 4000);
  const Counter& counter = *source;
  bench.in_odometry = [&counter](const FrameSlot& slot) {
    // Up to five of those behind it may be on their way; the others could only wait.
    while (slot.pair.index == 12 && counter.given < 12 + 9) nap_ms(0.2);
  };
  auto pipeline = Pipeline::start({.speed = 1.0, .catch_up_frames = 15}, bench, std::move(source));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  EXPECT_GE(pipeline->counts().dropped, 2);
  EXPECT_EQ(pipeline->counts().published + pipeline->counts().dropped, kFrames);
}

TEST(Pipeline, AStopLetsTheFramesOnTheirWayOut) {
  Bench bench;
  bench.stereo_ms = 5.0;
  bench.odometry_ms = 5.0;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(1'000'000, 20.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(150'000'000));
  pipeline->stop();
  ASSERT_TRUE(pipeline->wait_finished(10 * kSecondNs));
  EXPECT_TRUE(pipeline->outcome().ok());
  expect_consistent(bench, pipeline->counts());
  EXPECT_GT(pipeline->counts().published, 0);
}

TEST(Pipeline, AStopEndsAlsoAWaitForAFrameFarAhead) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(10, 3'600'000.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(20'000'000));
  pipeline->stop();
  EXPECT_TRUE(pipeline->wait_finished(10 * kSecondNs));
  EXPECT_EQ(pipeline->counts().published, 1);
}

TEST(Pipeline, ItsDestructorStopsIt) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(1'000'000, 1.0));
  ASSERT_TRUE(pipeline.ok());
}

}  // namespace
}  // namespace cliquevo::daemon
