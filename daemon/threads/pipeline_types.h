// SPDX-License-Identifier: BSD-3-Clause
// Inputs and outputs of Pipeline.
#pragma once

#include <cstdint>

#include "core/rt/thread.h"

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

struct PipelineCounts {
  std::int64_t grabbed = 0;    // pairs handed to the stereo stage
  std::int64_t published = 0;  // estimates that the output was given
  std::int64_t dropped = 0;    // pairs skipped because a newer one was there
  std::int64_t rejected = 0;   // pairs that a stage could not use
  std::int64_t unsent = 0;     // estimates lost because the output stood still for hundreds of frames
  std::int64_t source_errors = 0;
  std::int32_t resets = 0;
};

enum class StageId : int { stereo, odometry, output };
inline constexpr int kStages = 3;
const char* stage_name(StageId stage);

// What the histograms are of.
enum class Span : int { stereo, odometry, output, wake, total };
inline constexpr int kSpans = 5;
const char* span_name(Span span);

}  // namespace cliquevo::daemon
