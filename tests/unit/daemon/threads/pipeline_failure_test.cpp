// SPDX-License-Identifier: BSD-3-Clause
// What goes wrong in a source, a stage or the output, and the pipeline's own reports.
#include <atomic>
#include <memory>
#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

#include "daemon/threads/pipeline.h"
#include "tests/unit/daemon/threads/pipeline_bench.h"

namespace cliquevo::daemon {
namespace {

using test::Bench;
using test::Counter;
using test::expect_consistent;
using test::kSecondNs;
using test::nap_ms;

TEST(Pipeline, ATornPairEndsARecordingWithItsErrorAfterTheFramesBefore) {
  Bench bench;
  auto source = std::make_unique<Counter>(50, 1.0);
  source->torn_at = 20;
  auto pipeline = Pipeline::start({.speed = 0.0}, bench, std::move(source));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  ASSERT_FALSE(pipeline->outcome().ok());
  EXPECT_EQ(pipeline->outcome().error().what, "torn image");
  EXPECT_EQ(bench.out.size(), 20u);
}

TEST(Pipeline, ALiveSourceGoesOnAfterErrorsAndCountsThem) {
  Bench bench;
  bench.unusable_in_stereo = 5;
  bench.unusable_in_odometry = 7;
  auto source = std::make_unique<Counter>(50, 1.0);
  source->torn_at = 20;
  auto pipeline = Pipeline::start({.speed = 0.0, .errors_are_final = false}, bench, std::move(source));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  EXPECT_TRUE(pipeline->outcome().ok());
  EXPECT_EQ(pipeline->counts().source_errors, 1);
  EXPECT_EQ(pipeline->counts().rejected, 2);
  EXPECT_EQ(bench.out.size(), 47u);
  expect_consistent(bench, pipeline->counts());
}

TEST(Pipeline, AnUnusableFrameEndsARecordingWithItsError) {
  for (const bool in_stereo : {true, false}) {
    Bench bench;
    (in_stereo ? bench.unusable_in_stereo : bench.unusable_in_odometry) = 5;
    auto pipeline = Pipeline::start({.speed = 0.0}, bench, std::make_unique<Counter>(50, 1.0));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
    ASSERT_FALSE(pipeline->outcome().ok());
    EXPECT_EQ(pipeline->outcome().error().where, in_stereo ? "stereo" : "odometry");
    EXPECT_GE(bench.out.size(), 5u);
  }
}

TEST(Pipeline, AResetReachesTheOdometryAndIsCounted) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(60, 5.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(50'000'000));
  pipeline->request_reset();
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  EXPECT_EQ(bench.resets, 1);
  EXPECT_EQ(pipeline->counts().resets, 1);
  EXPECT_EQ(bench.out.front().resets, 0);
  EXPECT_EQ(bench.out.back().resets, 1);
}

TEST(Pipeline, OnlyAStageWithWorkThatDoesNotGetOnStandsStill) {
  for (const StageId hung : {StageId::stereo, StageId::odometry, StageId::output}) {
    Bench bench;
    rt::Wakeup release;
    std::atomic<bool> hanging{true};
    const auto hang = [&](const auto&) {
      while (hanging) release.wait(0, 1'000'000);
    };
    if (hung == StageId::stereo) bench.in_stereo = hang;
    if (hung == StageId::odometry) bench.in_odometry = hang;
    if (hung == StageId::output) bench.in_output = hang;
    auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(1'000'000, 2.0));
    ASSERT_TRUE(pipeline.ok());
    while (pipeline->standing_still_ns(hung) < 100'000'000) nap_ms(5);
    for (const StageId stage : {StageId::stereo, StageId::odometry, StageId::output}) {
      if (stage == hung) continue;
      // On a loaded machine the others may rest for a moment too, but not for good.
      const std::int64_t end_ns = monotonic_ns() + 20 * kSecondNs;
      while (pipeline->standing_still_ns(stage) > 50'000'000 && monotonic_ns() < end_ns) nap_ms(1);
      EXPECT_LT(monotonic_ns(), end_ns) << stage_name(stage);
    }
    hanging = false;
    pipeline->stop();
    ASSERT_TRUE(pipeline->wait_finished(10 * kSecondNs));
    EXPECT_EQ(pipeline->standing_still_ns(hung), 0);
  }
}

TEST(Pipeline, ASourceThatSendsNothingIsNotAStageStandingStill) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench, std::make_unique<Counter>(10, 3'600'000.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(50'000'000));
  for (const StageId stage : {StageId::stereo, StageId::odometry, StageId::output}) {
    EXPECT_EQ(pipeline->standing_still_ns(stage), 0);
  }
}

TEST(Pipeline, EveryFrameIsInTheHistograms) {
  Bench bench;
  bench.stereo_ms = 2.0;
  auto pipeline = Pipeline::start({.speed = 0.0}, bench, std::make_unique<Counter>(50, 1.0));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  for (const Span span : {Span::stereo, Span::odometry, Span::output, Span::wake, Span::total}) {
    EXPECT_EQ(pipeline->histogram(span).total(), 50u) << span_name(span);
  }
  EXPECT_GE(pipeline->histogram(Span::stereo).percentiles().p50_ns, 2'000'000);
  EXPECT_GE(pipeline->histogram(Span::total).percentiles().p50_ns, 2'000'000);
}

// Whatever a library throws, and wherever: an error with the thread's name, and every thread ends.
TEST(Pipeline, AnExceptionAnywhereEndsARecordingWithAnError) {
  for (const int where : {0, 1, 2, 3}) {
    Bench bench;
    auto source = std::make_unique<Counter>(400, 10.0);
    const auto fail_at = [](const FrameSlot& slot) {
      if (slot.pair.index == 20) throw std::bad_alloc();
    };
    if (where == 0) source->throws_at = 20;
    if (where == 1) bench.in_stereo = fail_at;
    if (where == 2) bench.in_odometry = fail_at;
    if (where == 3) {
      bench.in_output = [](const PublishedFrame& frame) {
        if (frame.index == 20) throw std::bad_alloc();
      };
    }
    auto pipeline = Pipeline::start({.speed = 0.0}, bench, std::move(source));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs)) << where;
    ASSERT_FALSE(pipeline->outcome().ok()) << where;
    EXPECT_EQ(pipeline->outcome().error().remedy, "no memory left") << where;
    EXPECT_GE(bench.out.size(), 20U) << where;
  }
}

TEST(Pipeline, ALiveSourceGoesOnAfterAnExceptionAnywhere) {
  Bench bench;
  auto source = std::make_unique<Counter>(60, 0.0);
  source->be_live();
  source->throws_at = 10;
  bench.in_stereo = [](const FrameSlot& slot) {
    if (slot.pair.index == 20) throw std::runtime_error("stereo");
  };
  bench.in_odometry = [](const FrameSlot& slot) {
    if (slot.pair.index == 30) throw std::runtime_error("odometry");
  };
  bench.in_output = [](const PublishedFrame& frame) {
    if (frame.index == 40) throw std::runtime_error("output");
  };
  auto pipeline = Pipeline::start({.catch_up_frames = 31}, bench, std::move(source));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  EXPECT_TRUE(pipeline->outcome().ok());
  EXPECT_EQ(pipeline->counts().source_errors, 1);
  EXPECT_EQ(bench.resets, pipeline->counts().resets);
  EXPECT_LE(pipeline->counts().resets, 1) << "after the odometry's, if that frame was not skipped";
  EXPECT_GT(bench.out.size(), 3U);
}

}  // namespace
}  // namespace cliquevo::daemon
