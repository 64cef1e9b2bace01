// SPDX-License-Identifier: BSD-3-Clause
// The way of a frame on threads: grab -> stereo -> odometry -> output. Between grab, stereo and odometry a hiccup is
// caught up with, and under overload the newest frame wins; what the odometry has seen goes out in order and once.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/rt/histogram.h"
#include "daemon/threads/pipeline_types.h"
#include "daemon/threads/pipeline_work.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

class Pipeline {
 public:
  // work: outlives the pipeline. source: kept open by the pipeline, used by its grab thread alone.
  static Result<Pipeline> start(const PipelineOptions& options, PipelineWork& work,
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
  std::int64_t standing_still_ns(StageId stage) const;
  const rt::Histogram& histogram(Span span) const;
  // The source's own status; empty = nothing to report.
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
