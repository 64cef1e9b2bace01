// SPDX-License-Identifier: BSD-3-Clause
// After warm-up the stereo and the odometry thread allocate nothing, take no lock, touch no file and fault no page in.
#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "core/rt/memory.h"
#include "daemon/daemon_work.h"
#include "daemon/output.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/source.h"
#include "daemon/pipeline/stages.h"
#include "daemon/start_up.h"
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

// What the daemon does with a frame, with a watch on each of the two threads.
class WatchedWork final : public PipelineWork {
 public:
  explicit WatchedWork(PipelineWork& work) : work_(work) {}

  void prepare(FrameSlot& slot) override { work_.prepare(slot); }
  Result<void> stereo(FrameSlot& slot) override {
    stereo_watch.before_frame();
    return work_.stereo(slot);
  }
  Result<void> odometry(FrameSlot& slot, PublishedFrame& out) override {
    odometry_watch.before_frame();
    return work_.odometry(slot, out);
  }
  void reset() override { work_.reset(); }
  void output(const PublishedFrame& frame) override {
    ++published;
    if (frame.estimate.status == vo::Status::valid) ++valid;
    work_.output(frame);
  }

  ThreadWatch stereo_watch;
  ThreadWatch odometry_watch;
  std::atomic<std::int64_t> published{0};
  std::atomic<std::int64_t> valid{0};

 private:
  PipelineWork& work_;
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

// Messages go into a log, which the output thread writes.
void expect_none_with(LcmConfig lcm) {
  const std::string refused = rt::lock_memory();
  lcm.url = "file://" + test::scratch_dir() + "/sent.lcm?mode=w";
  Config config = default_config();
  config.lcm = std::move(lcm);
  config.source.loop = "pingpong";
  config.source.simulator.width = 320;
  config.source.simulator.height = 240;
  config.source.simulator.focal_px = 350.0;
  config.source.simulator.frames = 20;
  config.source.simulator.movers = 2;
  auto source = open_source(config.source);
  ASSERT_TRUE(source.ok()) << source.error().line();
  auto stereo = StereoStage::make(config.stereo, (*source)->info());
  ASSERT_TRUE(stereo.ok());
  auto odometry = OdometryStage::make(config.odometry, (*source)->info(), *stereo);
  ASSERT_TRUE(odometry.ok());
  Rig rig{std::move(*source), {}, std::move(*stereo), std::move(*odometry)};
  auto publisher = Publisher::make(config.lcm, config.T_body_camera);
  ASSERT_TRUE(publisher.ok()) << publisher.error().line();
  auto output = Output::make(std::move(*publisher), config, rig.stereo.model(), rig.odometry.mask(), "");
  ASSERT_TRUE(output.ok()) << output.error().line();

  DaemonWork daemon_work(rig, **output, !config.lcm.movers_channel.empty());
  WatchedWork work(daemon_work);
  auto pipeline = Pipeline::start({.speed = 0.0}, work, std::move(rig.source));
  ASSERT_TRUE(pipeline.ok());
  const std::int64_t wanted = kWarmUp + watched_frames();
  while (work.published < wanted && !pipeline->wait_finished(20'000'000)) {
  }
  pipeline->stop();
  ASSERT_TRUE(pipeline->wait_finished(60'000'000'000));
  EXPECT_GE(work.odometry_watch.frames(), watched_frames() - 2);
  EXPECT_GT(work.valid, work.published * 9 / 10) << "the frames must be worth watching";
  expect_none(work.stereo_watch, "stereo", refused.empty());
  expect_none(work.odometry_watch, "odometry", refused.empty());
}

TEST(RealtimeCalls, NoneInTheStereoAndTheOdometryThreadAfterWarmUp) { expect_none_with({}); }

// As pages and bridges want it: what they are sent is taken off both threads.
TEST(RealtimeCalls, NoneWhileEverythingThatViewsAndBridgesReceiveIsSent) {
  LcmConfig lcm;
  lcm.delta_body_channel = "VO_DELTA_BODY";
  lcm.images_channel = "VO_IMAGES";
  lcm.images_rate_hz = 30.0;
  lcm.images_right = true;
  lcm.points_channel = "VO_POINTS";
  lcm.points_rate_hz = 10.0;
  lcm.movers_channel = "VO_MOVERS";
  lcm.features_channel = "VO_FEATURES";
  expect_none_with(lcm);
}

}  // namespace
}  // namespace cliquevo::daemon
