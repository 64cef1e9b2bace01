// SPDX-License-Identifier: BSD-3-Clause
// After warm-up the stereo and the odometry thread allocate nothing, take no lock, touch no file and fault no page in.
#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "core/rt/memory.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/source.h"
#include "daemon/threads/pipeline.h"
#include "tests/support/test_data.h"
#include "tests/system/interpose/interposer.h"

namespace cliquevo::daemon {
namespace {

constexpr std::int64_t kWarmUp = 60;

// The run of the label `bench` sets 10000.
std::int64_t watched_frames() {
  const char* set = std::getenv("CLIQUEVO_WATCHED_FRAMES");
  return set != nullptr ? std::stoll(set) : 120;
}

// Watches the thread that calls it, all of it: what is between two calls counts too.
class ThreadWatch {
 public:
  void before_frame() {
    if (seen_++ == kWarmUp) test::watch_this_thread();
    if (seen_ > kWarmUp) calls_ = test::calls_of_this_thread();
  }
  std::int64_t frames() const { return seen_ - kWarmUp - 1; }
  const test::ForbiddenCalls& calls() const { return calls_; }

 private:
  std::int64_t seen_ = 0;
  test::ForbiddenCalls calls_;  // up to the beginning of the last frame
};

void expect_none(const ThreadWatch& watch, const char* thread, bool locked) {
  const test::ForbiddenCalls& calls = watch.calls();
  EXPECT_EQ(calls.allocations, 0) << thread << ": " << calls.first;
  EXPECT_EQ(calls.locks, 0) << thread << ": " << calls.first;
  EXPECT_EQ(calls.input_output, 0) << thread << ": " << calls.first;
  if (!locked) return;
  EXPECT_EQ(calls.minor_faults, 0) << thread;
  EXPECT_EQ(calls.major_faults, 0) << thread;
}

TEST(RealtimeCalls, TheWatchSeesWhatItIsThereFor) {
  std::thread([] {
    test::watch_this_thread();
    EXPECT_EQ(test::calls_of_this_thread().allocations, 0);
    delete new std::string(100, 'x');
    std::FILE* file = std::fopen("/dev/null", "r");
    if (file != nullptr) std::fclose(file);
    pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&mutex);
    pthread_mutex_unlock(&mutex);
    const test::ForbiddenCalls calls = test::calls_of_this_thread();
    EXPECT_GE(calls.allocations, 4);
    EXPECT_EQ(calls.locks, 2);
    EXPECT_GE(calls.input_output, 1);
    EXPECT_STREQ(calls.first, "malloc");
  }).join();
}

TEST(RealtimeCalls, NoneInTheStereoAndTheOdometryThreadAfterWarmUp) {
  const std::string refused = rt::lock_memory();
  Config config = default_config();
  config.source.loop = "pingpong";
  config.source.simulator.width = 320;
  config.source.simulator.height = 240;
  config.source.simulator.focal_px = 350.0;
  config.source.simulator.frames = 20;
  auto source = open_source(config.source);
  ASSERT_TRUE(source.ok()) << source.error().line();
  auto stereo = StereoStage::make(config.stereo, (*source)->info());
  ASSERT_TRUE(stereo.ok());
  auto odometry = OdometryStage::make(config.odometry, (*source)->info(), *stereo);
  ASSERT_TRUE(odometry.ok());

  ThreadWatch stereo_watch;
  ThreadWatch odometry_watch;
  std::atomic<std::int64_t> published{0};
  std::atomic<std::int64_t> valid{0};
  PipelineWork work;
  work.prepare = [&](FrameSlot& slot) { stereo->prepare(slot.frame); };
  work.stereo = [&](FrameSlot& slot) {
    stereo_watch.before_frame();
    return stereo->run(slot.pair, slot.frame);
  };
  work.odometry = [&](FrameSlot& slot) {
    odometry_watch.before_frame();
    return odometry->run(slot.pair.stamp_ns, slot.frame);
  };
  work.estimate = [&]() -> const vo::Estimate& { return odometry->estimate(); };
  work.reset = [&] { odometry->reset(); };
  work.output = [&](const PublishedFrame& frame) {
    ++published;
    if (frame.estimate.status == vo::Status::valid) ++valid;
  };
  auto pipeline = Pipeline::start({.speed = 0.0}, work, std::move(*source));
  ASSERT_TRUE(pipeline.ok());
  const std::int64_t wanted = kWarmUp + watched_frames();
  while (published < wanted && !pipeline->wait_finished(20'000'000)) {
  }
  pipeline->stop();
  ASSERT_TRUE(pipeline->wait_finished(60'000'000'000));
  EXPECT_GE(odometry_watch.frames(), watched_frames() - 2);
  EXPECT_GT(valid, published * 9 / 10) << "the frames must be worth watching";
  expect_none(stereo_watch, "stereo", refused.empty());
  expect_none(odometry_watch, "odometry", refused.empty());
}

}  // namespace
}  // namespace cliquevo::daemon
