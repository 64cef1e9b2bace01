// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline.h"

#include <algorithm>
#include <atomic>
#include <new>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/rt/wakeup.h"

namespace cliquevo::daemon {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

void nap_ms(double ms) { rt::Wakeup().wait(0, static_cast<std::int64_t>(ms * 1e6)); }

// Frames with nothing in them but a number, `period_ms` apart.
class Counter : public drivers::FrameSource {
 public:
  Counter(std::int64_t frames, double period_ms, int side_px = 16)
      : frames_(frames), period_ns_(static_cast<std::int64_t>(period_ms * 1e6)) {
    info_.width = side_px;
    info_.height = side_px;
    info_.frame_count = frames;
  }
  const drivers::SourceInfo& info() const override { return info_; }
  Result<bool> next(drivers::StereoPair& pair) override {
    if (at_ == torn_at) {
      ++at_;
      return Error{"torn image", "frame", "copy it again"};
    }
    if (at_ == throws_at) {
      ++at_;
      throw std::bad_alloc();
    }
    if (at_ >= frames_) return false;
    pair.index = at_;
    pair.stamp_ns = 1'000 + at_ * period_ns_;
    ++at_;
    given = at_;
    return true;
  }
  void be_live() { info_.live = true; }
  std::int64_t torn_at = -1;
  std::int64_t throws_at = -1;
  std::atomic<std::int64_t> given{0};

 private:
  drivers::SourceInfo info_;
  std::int64_t frames_;
  std::int64_t period_ns_;
  std::int64_t at_ = 0;
};

// Work that takes the given times and notes what came out.
struct Bench {
  double stereo_ms = 0.0;
  double odometry_ms = 0.0;
  double output_ms = 0.0;
  std::int64_t unusable_in_stereo = -1;
  std::int64_t unusable_in_odometry = -1;
  std::vector<PublishedFrame> out;
  vo::Estimate estimate;
  std::atomic<int> resets{0};

  PipelineWork work() {
    PipelineWork w;
    w.prepare = [](FrameSlot&) {};
    w.stereo = [this](FrameSlot& slot) -> Result<void> {
      if (stereo_ms > 0) nap_ms(stereo_ms);
      if (slot.pair.index == unusable_in_stereo) return Error{"unusable", "stereo", "look"};
      slot.frame.times.stereo_ns = slot.pair.index;
      return {};
    };
    w.odometry = [this](FrameSlot& slot) -> Result<void> {
      if (odometry_ms > 0) nap_ms(odometry_ms);
      if (slot.pair.index == unusable_in_odometry) return Error{"unusable", "odometry", "look"};
      estimate.stamp_ns = slot.pair.stamp_ns;
      return {};
    };
    w.estimate = [this]() -> const vo::Estimate& { return estimate; };
    w.reset = [this] { ++resets; };
    w.output = [this](const PublishedFrame& frame) {
      if (output_ms > 0) nap_ms(output_ms);
      out.push_back(frame);
    };
    return w;
  }
};

// Indices rise strictly, each frame goes out once and unmixed, and every frame grabbed went out or is counted.
void expect_consistent(const Bench& bench, const PipelineCounts& counts) {
  std::int64_t last = -1;
  std::int64_t last_dropped = 0;
  for (const PublishedFrame& frame : bench.out) {
    EXPECT_GT(frame.index, last);
    EXPECT_EQ(frame.times.stereo_ns, frame.index);
    EXPECT_GE(frame.dropped, last_dropped);
    const FrameStamps& s = frame.stamps;
    EXPECT_GT(s.grabbed_ns, 0);
    last = frame.index;
    last_dropped = frame.dropped;
  }
  EXPECT_EQ(static_cast<std::int64_t>(bench.out.size()), counts.published);
  EXPECT_EQ(counts.grabbed, counts.published + counts.dropped + counts.rejected + counts.unsent);
}

TEST(Pipeline, WithoutAPaceEveryFrameGoesThroughHoweverSlowAStageIs) {
  for (const int slow : {0, 1, 2}) {
    Bench bench;
    (slow == 0 ? bench.stereo_ms : slow == 1 ? bench.odometry_ms : bench.output_ms) = 0.5;
    auto pipeline = Pipeline::start({.speed = 0.0}, bench.work(), std::make_unique<Counter>(400, 10.0));
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
    PipelineWork work = bench.work();
    auto& slow = stereo_is_slow ? work.stereo : work.odometry;
    slow = [dawdle, quick = slow](FrameSlot& slot) {
      dawdle(slot);
      return quick(slot);
    };
    auto pipeline = Pipeline::start({.speed = 1.0}, work, std::move(source));
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
    PipelineWork work = bench.work();
    auto& stage = stereo_hiccups ? work.stereo : work.odometry;
    stage = [&counter, quick = stage](FrameSlot& slot) {
      // Until three more are given at least; the fourth is being waited for then.
      while (slot.pair.index == kAt && counter.given < kAt + 5) nap_ms(0.2);
      return quick(slot);
    };
    auto pipeline = Pipeline::start({.speed = 1.0, .catch_up_frames = 15}, work, std::move(source));
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
  PipelineWork work = bench.work();
  work.odometry = [&counter, quick = work.odometry](FrameSlot& slot) {
    // Up to five of those behind it may be on their way; the others could only wait.
    while (slot.pair.index == 12 && counter.given < 12 + 9) nap_ms(0.2);
    return quick(slot);
  };
  auto pipeline = Pipeline::start({.speed = 1.0, .catch_up_frames = 15}, work, std::move(source));
  ASSERT_TRUE(pipeline.ok());
  ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
  EXPECT_GE(pipeline->counts().dropped, 2);
  EXPECT_EQ(pipeline->counts().published + pipeline->counts().dropped, kFrames);
}

TEST(Pipeline, AStopLetsTheFramesOnTheirWayOut) {
  Bench bench;
  bench.stereo_ms = 5.0;
  bench.odometry_ms = 5.0;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench.work(), std::make_unique<Counter>(1'000'000, 20.0));
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
  auto pipeline = Pipeline::start({.speed = 1.0}, bench.work(), std::make_unique<Counter>(10, 3'600'000.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(20'000'000));
  pipeline->stop();
  EXPECT_TRUE(pipeline->wait_finished(10 * kSecondNs));
  EXPECT_EQ(pipeline->counts().published, 1);
}

TEST(Pipeline, ItsDestructorStopsIt) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench.work(), std::make_unique<Counter>(1'000'000, 1.0));
  ASSERT_TRUE(pipeline.ok());
}

TEST(Pipeline, ATornPairEndsARecordingWithItsErrorAfterTheFramesBefore) {
  Bench bench;
  auto source = std::make_unique<Counter>(50, 1.0);
  source->torn_at = 20;
  auto pipeline = Pipeline::start({.speed = 0.0}, bench.work(), std::move(source));
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
  auto pipeline = Pipeline::start({.speed = 0.0, .errors_are_final = false}, bench.work(), std::move(source));
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
    auto pipeline = Pipeline::start({.speed = 0.0}, bench.work(), std::make_unique<Counter>(50, 1.0));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs));
    ASSERT_FALSE(pipeline->outcome().ok());
    EXPECT_EQ(pipeline->outcome().error().where, in_stereo ? "stereo" : "odometry");
    EXPECT_GE(bench.out.size(), 5u);
  }
}

TEST(Pipeline, AResetReachesTheOdometryAndIsCounted) {
  Bench bench;
  auto pipeline = Pipeline::start({.speed = 1.0}, bench.work(), std::make_unique<Counter>(60, 5.0));
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
  for (const Stage hung : {Stage::stereo, Stage::odometry, Stage::output}) {
    Bench bench;
    rt::Wakeup release;
    PipelineWork work = bench.work();
    std::atomic<bool> hanging{true};
    const auto hang = [&] {
      while (hanging) release.wait(0, 1'000'000);
    };
    const auto inner = work;
    if (hung == Stage::stereo)
      work.stereo = [&, inner](FrameSlot& s) {
        hang();
        return inner.stereo(s);
      };
    if (hung == Stage::odometry)
      work.odometry = [&, inner](FrameSlot& s) {
        hang();
        return inner.odometry(s);
      };
    if (hung == Stage::output)
      work.output = [&, inner](const PublishedFrame& f) {
        hang();
        inner.output(f);
      };
    auto pipeline = Pipeline::start({.speed = 1.0}, work, std::make_unique<Counter>(1'000'000, 2.0));
    ASSERT_TRUE(pipeline.ok());
    while (pipeline->standing_still_ns(hung) < 100'000'000) nap_ms(5);
    for (const Stage stage : {Stage::stereo, Stage::odometry, Stage::output}) {
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
  auto pipeline = Pipeline::start({.speed = 1.0}, bench.work(), std::make_unique<Counter>(10, 3'600'000.0));
  ASSERT_TRUE(pipeline.ok());
  EXPECT_FALSE(pipeline->wait_finished(50'000'000));
  for (const Stage stage : {Stage::stereo, Stage::odometry, Stage::output}) {
    EXPECT_EQ(pipeline->standing_still_ns(stage), 0);
  }
}

TEST(Pipeline, EveryFrameIsInTheHistograms) {
  Bench bench;
  bench.stereo_ms = 2.0;
  auto pipeline = Pipeline::start({.speed = 0.0}, bench.work(), std::make_unique<Counter>(50, 1.0));
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
    PipelineWork work = bench.work();
    auto source = std::make_unique<Counter>(400, 10.0);
    const auto fail_at = [](const FrameSlot& slot) {
      if (slot.pair.index == 20) throw std::bad_alloc();
    };
    if (where == 0) source->throws_at = 20;
    if (where == 1) work.stereo = [&, old = work.stereo](FrameSlot& slot) { return fail_at(slot), old(slot); };
    if (where == 2) work.odometry = [&, old = work.odometry](FrameSlot& slot) { return fail_at(slot), old(slot); };
    if (where == 3) {
      work.output = [&, old = work.output](const PublishedFrame& frame) {
        if (frame.index == 20) throw std::bad_alloc();
        old(frame);
      };
    }
    auto pipeline = Pipeline::start({.speed = 0.0}, std::move(work), std::move(source));
    ASSERT_TRUE(pipeline.ok());
    ASSERT_TRUE(pipeline->wait_finished(60 * kSecondNs)) << where;
    ASSERT_FALSE(pipeline->outcome().ok()) << where;
    EXPECT_EQ(pipeline->outcome().error().remedy, "no memory left") << where;
    EXPECT_GE(bench.out.size(), 20U) << where;
  }
}

TEST(Pipeline, ALiveSourceGoesOnAfterAnExceptionAnywhere) {
  Bench bench;
  PipelineWork work = bench.work();
  auto source = std::make_unique<Counter>(60, 0.0);
  source->be_live();
  source->throws_at = 10;
  work.stereo = [old = work.stereo](FrameSlot& slot) {
    if (slot.pair.index == 20) throw std::runtime_error("stereo");
    return old(slot);
  };
  work.odometry = [old = work.odometry](FrameSlot& slot) {
    if (slot.pair.index == 30) throw std::runtime_error("odometry");
    return old(slot);
  };
  work.output = [old = work.output](const PublishedFrame& frame) {
    if (frame.index == 40) throw std::runtime_error("output");
    old(frame);
  };
  auto pipeline = Pipeline::start({.catch_up_frames = 31}, std::move(work), std::move(source));
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
