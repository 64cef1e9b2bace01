// SPDX-License-Identifier: BSD-3-Clause
// What the pipeline's threads share: slots, the ways between the stages, counts, and the end.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "core/base/result.h"
#include "core/rt/handover.h"
#include "core/rt/histogram.h"
#include "core/rt/ring.h"
#include "core/rt/slot_pool.h"
#include "core/rt/wakeup.h"
#include "daemon/threads/frame_slot.h"
#include "daemon/threads/pipeline_types.h"
#include "daemon/threads/pipeline_work.h"
#include "daemon/threads/progress.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

// Threads that give slots back.
enum ReturningThread { kFromStereo, kFromOdometry, kReturningThreads };

struct Outgoing {
  PublishedFrame frame;
  std::int64_t grabbed_mono_ns = 0;
};

struct PipelineState {
  static constexpr int kNone = rt::Handover::kNone;
  static constexpr std::int64_t kPollNs = 20'000'000;  // how often a wait looks whether it should stop
  // Estimates that wait for the output: eight seconds at 30 Hz before one is lost.
  static constexpr std::size_t kOutgoing = 256;

  PipelineState(const PipelineOptions& options, PipelineWork& work, std::unique_ptr<drivers::FrameSource> source);

  bool lossless() const { return options.speed <= 0.0; }
  bool stopping() const { return stop_asked.load(std::memory_order_acquire); }
  bool has_failed() const { return failed.load(std::memory_order_acquire); }
  // false: stopped.
  bool sleep_until(std::int64_t due_mono_ns);
  // Ends the pipeline with an error; the first one counts.
  void fail(const Error& what);
  void ask_stop();
  Progress& progress(StageId stage) { return progresses[static_cast<std::size_t>(stage)]; }
  rt::Histogram& span(Span which) { return spans[static_cast<std::size_t>(which)]; }
  std::int64_t total_dropped() const {
    return dropped_before_stereo.load(std::memory_order_relaxed) +
           dropped_before_odometry.load(std::memory_order_relaxed);
  }
  PipelineCounts counts() const;

  PipelineOptions options;
  PipelineWork& work;
  std::unique_ptr<drivers::FrameSource> source;
  bool live;

  int backlog;
  rt::SlotPool<FrameSlot> slots;
  rt::Handover to_stereo{backlog};
  rt::Handover to_odometry{backlog};
  rt::Ring<Outgoing> outgoing{kOutgoing};
  rt::Wakeup stop_wakeup;
  std::atomic<bool> stop_asked{false};
  std::atomic<bool> reset_asked{false};

  std::atomic<std::int64_t> grabbed{0};
  std::atomic<std::int64_t> published{0};
  std::atomic<std::int64_t> dropped_before_stereo{0};
  std::atomic<std::int64_t> dropped_before_odometry{0};
  std::atomic<std::int64_t> rejected{0};
  std::atomic<std::int64_t> unsent{0};
  std::atomic<std::int64_t> source_errors{0};
  std::atomic<std::int32_t> resets{0};
  std::array<Progress, kStages> progresses;
  std::array<rt::Histogram, kSpans> spans;

  std::atomic<bool> failed{false};
  Error error;  // written once, by the thread that set `failed`; read once finished
  std::atomic<bool> finished{false};
  rt::Wakeup finished_wakeup;
};

}  // namespace cliquevo::daemon
