// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline_state.h"

#include <algorithm>
#include <utility>

#include "core/base/time.h"

namespace cliquevo::daemon {

namespace {

// One each in the work of grabber, stereo and odometry, backlog + 1 waiting between two of them, and one to spare.
constexpr int slots_for(int backlog) { return 2 * backlog + 6; }

// Slots are locked in memory: of large images fewer may wait than configured.
int backlog_within(int wanted, const drivers::SourceInfo& info) {
  constexpr std::int64_t kMostBytes = std::int64_t{256} << 20;
  constexpr std::int64_t kBytesPerPixel = 7;  // raw and rectified pair, filtered image, disparity
  const std::int64_t slot = std::max<std::int64_t>(1, kBytesPerPixel * info.width * info.height);
  const std::int64_t most = (kMostBytes / slot - slots_for(0)) / (slots_for(1) - slots_for(0));
  return static_cast<int>(
      std::clamp<std::int64_t>(std::min<std::int64_t>(wanted, most), 0, rt::Handover::kMostBacklog));
}

PipelineOptions for_source(PipelineOptions options, const drivers::FrameSource& source) {
  options.catch_up_frames = backlog_within(options.catch_up_frames, source.info());
  if (source.info().live) {
    options.speed = 1.0;
    options.errors_are_final = false;
  }
  return options;
}

}  // namespace

PipelineState::PipelineState(const PipelineOptions& options_, PipelineWork& work_,
                             std::unique_ptr<drivers::FrameSource> source_)
    : options(for_source(options_, *source_)),
      work(work_),
      source(std::move(source_)),
      live(source->info().live),
      backlog(lossless() ? 0 : options.catch_up_frames),
      slots(slots_for(backlog), kReturningThreads) {}

void PipelineState::fail(const Error& what) {
  if (!failed.exchange(true)) error = what;
  ask_stop();
}

void PipelineState::ask_stop() {
  stop_asked.store(true, std::memory_order_release);
  stop_wakeup.signal();
  source->interrupt();
}

bool PipelineState::sleep_until(std::int64_t due_mono_ns) {
  for (;;) {
    const std::uint32_t seen = stop_wakeup.state();
    if (stopping()) return false;
    const std::int64_t left_ns = due_mono_ns - monotonic_ns();
    if (left_ns <= 0) return true;
    stop_wakeup.wait(seen, left_ns);
  }
}

PipelineCounts PipelineState::counts() const {
  PipelineCounts out;
  out.grabbed = grabbed.load(std::memory_order_relaxed);
  out.published = published.load(std::memory_order_relaxed);
  out.dropped = total_dropped();
  out.rejected = rejected.load(std::memory_order_relaxed);
  out.unsent = unsent.load(std::memory_order_relaxed);
  out.source_errors = source_errors.load(std::memory_order_relaxed);
  out.resets = resets.load(std::memory_order_relaxed);
  return out;
}

}  // namespace cliquevo::daemon
