// SPDX-License-Identifier: BSD-3-Clause
// The way of a frame on threads: grab -> stereo -> odometry -> output. Between grab, stereo and odometry a hiccup is
// caught up with, and under overload the newest frame wins; what the odometry has seen goes out in order and once.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/rt/histogram.h"
#include "core/rt/thread.h"
#include "daemon/pipeline/published_frame.h"
#include "daemon/threads/frame_slot.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

struct PipelineOptions {
  // A live source sets the pace itself, and its errors are counted; these two are for the others.
  double speed = 1.0;            // times the source's own pace; 0: each frame waits for the one before, none is dropped
  bool errors_are_final = true;  // of the source and of single frames: end with it (recordings), or count and go on
  // How many frames may wait behind another, before stereo and before odometry: rt::Handover's backlog.
  int catch_up_frames = 20;
  rt::ThreadOptions stereo{.name = "vo-stereo"};
  rt::ThreadOptions odometry{.name = "vo-odometry"};
  rt::ThreadOptions output{.name = "vo-output"};
};

// What the two working threads do; the daemon gives the stages of stages.h.
struct PipelineWork {
  std::function<void(FrameSlot&)> prepare;            // once a slot, before the threads start
  std::function<Result<void>(FrameSlot&)> stereo;     // stereo thread
  std::function<Result<void>(FrameSlot&)> odometry;   // odometry thread
  std::function<const vo::Estimate&()> estimate;      // odometry thread, after odometry()
  std::function<const vo::Movers&()> movers;          // likewise; may be empty
  std::function<void()> reset;                        // odometry thread: forget all frames
  std::function<void(const PublishedFrame&)> output;  // output thread
};

struct PipelineCounts {
  std::int64_t grabbed = 0;    // pairs handed to the stereo stage
  std::int64_t published = 0;  // estimates that the output was given
  std::int64_t dropped = 0;    // pairs skipped because a newer one was there
  std::int64_t rejected = 0;   // pairs that a stage could not use
  std::int64_t unsent = 0;     // estimates lost because the output stood still for hundreds of frames
  std::int64_t source_errors = 0;
  std::int32_t resets = 0;
};

enum class Stage : int { stereo, odometry, output };
inline constexpr int kStages = 3;
const char* stage_name(Stage stage);

// What the histograms are of.
enum class Span : int { stereo, odometry, output, wake, total };
inline constexpr int kSpans = 5;
const char* span_name(Span span);

class Pipeline {
 public:
  // source: kept open by the pipeline, used by its grab thread alone.
  static Result<Pipeline> start(const PipelineOptions& options, PipelineWork work,
                                std::unique_ptr<drivers::FrameSource> source);
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();  // stops and waits until finished

  // No further frame is grabbed; those on their way still go out.
  void stop();
  // Sleeps until every frame has gone out, whether stopped or at the source's end. false: timed out.
  bool wait_finished(std::int64_t timeout_ns);
  // Before the next frame, the odometry forgets all frames and starts at the identity.
  void request_reset();

  PipelineCounts counts() const;
  // What ended it, if not the source's end or stop(). Once finished.
  Result<void> outcome() const;
  // How long the stage has had work without finishing any, ns; 0 when it has none.
  std::int64_t standing_still_ns(Stage stage) const;
  const rt::Histogram& histogram(Span span) const;
  // The source's own word on how it gets on; empty = nothing to tell.
  std::string source_status() const;
  // What the images show to be wrong with the source; empty = nothing.
  std::string source_finding() const;
  // Rights the threads were not granted, a line a thread; empty = all granted.
  std::vector<std::string> shortfalls() const;

 private:
  struct Impl;
  explicit Pipeline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
