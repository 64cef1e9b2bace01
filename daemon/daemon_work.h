// SPDX-License-Identifier: BSD-3-Clause
// What the pipeline's threads do in the daemon: the stages of daemon/pipeline, and the output.
#pragma once

#include "daemon/output.h"
#include "daemon/start_up.h"
#include "daemon/threads/pipeline_work.h"

namespace cliquevo::daemon {

class DaemonWork final : public PipelineWork {
 public:
  // Both outlive it. with_movers: whether anybody receives them.
  DaemonWork(Rig& rig, Output& output, bool with_movers) : rig_(rig), output_(output), with_movers_(with_movers) {}

  void prepare(FrameSlot& slot) override;
  Result<void> stereo(FrameSlot& slot) override;
  Result<void> odometry(FrameSlot& slot, PublishedFrame& out) override;
  void reset() override;
  void output(const PublishedFrame& frame) override;

 private:
  Rig& rig_;
  Output& output_;
  bool with_movers_;
};

// The stereo thread's helpers wait for each other: all of them run like it.
void schedule_workers(const RealtimeConfig& config, StereoStage& stereo);

}  // namespace cliquevo::daemon
