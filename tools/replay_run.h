// SPDX-License-Identifier: BSD-3-Clause
// The loop of `cliquevo replay`: every pair of a source through the pipeline, and what is written meanwhile.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "daemon/lcm/publisher.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/frame_pipeline.h"
#include "daemon/pipeline/trajectory_file.h"
#include "drivers/frame_source.h"
#include "tools/drawing.h"
#include "tools/run_log.h"

namespace cliquevo::tools {

struct ReplayOutputs {
  std::optional<daemon::TrajectoryWriter> trajectory;
  std::optional<daemon::Publisher> publisher;
  double speed = 0.0;                 // times recorded pace; 0 = as fast as possible
  std::unique_ptr<RunReport> report;  // gets every frame; none: no report is wanted
  bool strict = false;                // the first pair that cannot be played ends the run
};

struct ReplayEnd {
  std::optional<Error> error;  // what ended the run early; all frames before it are in the log and the trajectory
  bool by_strictness = false;  // it is a pair that would have been skipped
  double wall_s = 0.0;
};

// Never drops a frame. A pair that the source cannot deliver is skipped and reported; its line of the trajectory holds
// the pose before it (but for a stamp that does not rise, in a trajectory with stamps). Ends at the source's end, at
// the first pair that cannot be processed, or soon after SIGINT or SIGTERM.
ReplayEnd run_replay(drivers::FrameSource& source, daemon::FramePipeline& pipeline, ReplayOutputs& outputs,
                     RunLog& log);

}  // namespace cliquevo::tools
