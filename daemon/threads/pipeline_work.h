// SPDX-License-Identifier: BSD-3-Clause
// What the pipeline's threads do with a frame; the pipeline itself only moves frames from one to the next.
#pragma once

#include "core/base/result.h"
#include "daemon/pipeline/published_frame.h"
#include "daemon/threads/frame_slot.h"

namespace cliquevo::daemon {

class PipelineWork {
 public:
  virtual ~PipelineWork() = default;
  // Once a slot, before the threads start: takes all memory that the stages will use.
  virtual void prepare(FrameSlot& slot) = 0;
  // Stereo thread.
  virtual Result<void> stereo(FrameSlot& slot) = 0;
  // Odometry thread: fills in estimate and movers.
  virtual Result<void> odometry(FrameSlot& slot, PublishedFrame& out) = 0;
  // Odometry thread: forget all frames.
  virtual void reset() = 0;
  // Output thread.
  virtual void output(const PublishedFrame& frame) = 0;
};

}  // namespace cliquevo::daemon
