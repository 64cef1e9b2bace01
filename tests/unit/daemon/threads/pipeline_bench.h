// SPDX-License-Identifier: BSD-3-Clause
// A source and work for the pipeline that do nothing but what a test needs.
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <new>
#include <vector>

#include <gtest/gtest.h>

#include "core/rt/wakeup.h"
#include "daemon/threads/pipeline.h"

namespace cliquevo::daemon::test {

constexpr std::int64_t kSecondNs = 1'000'000'000;

inline void nap_ms(double ms) { rt::Wakeup().wait(0, static_cast<std::int64_t>(ms * 1e6)); }

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
struct Bench : PipelineWork {
  double stereo_ms = 0.0;
  double odometry_ms = 0.0;
  double output_ms = 0.0;
  std::int64_t unusable_in_stereo = -1;
  std::int64_t unusable_in_odometry = -1;
  // What a test does in a stage before its work.
  std::function<void(const FrameSlot&)> in_stereo;
  std::function<void(const FrameSlot&)> in_odometry;
  std::function<void(const PublishedFrame&)> in_output;

  std::vector<PublishedFrame> out;
  std::atomic<int> resets{0};

  void prepare(FrameSlot&) override {}
  Result<void> stereo(FrameSlot& slot) override {
    if (in_stereo) in_stereo(slot);
    if (stereo_ms > 0) nap_ms(stereo_ms);
    if (slot.pair.index == unusable_in_stereo) return Error{"unusable", "stereo", "look"};
    slot.frame.times.stereo_ns = slot.pair.index;
    return {};
  }
  Result<void> odometry(FrameSlot& slot, PublishedFrame& published) override {
    if (in_odometry) in_odometry(slot);
    if (odometry_ms > 0) nap_ms(odometry_ms);
    if (slot.pair.index == unusable_in_odometry) return Error{"unusable", "odometry", "look"};
    published.estimate.stamp_ns = slot.pair.stamp_ns;
    return {};
  }
  void reset() override { ++resets; }
  void output(const PublishedFrame& frame) override {
    if (in_output) in_output(frame);
    if (output_ms > 0) nap_ms(output_ms);
    out.push_back(frame);
  }
};

// Indices rise strictly, each frame goes out once and unmixed, and every frame grabbed went out or is counted.
inline void expect_consistent(const Bench& bench, const PipelineCounts& counts) {
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

}  // namespace cliquevo::daemon::test
