// SPDX-License-Identifier: BSD-3-Clause
// The way of one frame, without threads: raw pair -> rectify -> dense stereo -> odometry -> estimate. Replay runs it as
// it stands; the daemon runs the same steps on its threads.
#pragma once

#include <memory>
#include <vector>

#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/stage_times.h"
#include "drivers/frame_source.h"
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"

namespace cliquevo::daemon {

struct PipelineParams {
  stereo::StereoParams stereo;
  vo::VoParams odometry;
  stereo::RectifyParams rectify;  // no scale: the native size, so that it does not depend on the machine
};

class FramePipeline {
 public:
  static Result<FramePipeline> make(const PipelineParams& params, const drivers::SourceInfo& source);
  FramePipeline(FramePipeline&&) noexcept;
  FramePipeline& operator=(FramePipeline&&) noexcept;
  ~FramePipeline();

  // An Error names unusable input (unequal sizes ...); the state is as before. Allocates nothing after the first
  // frames.
  Result<void> process(const drivers::StereoPair& pair);
  const vo::Estimate& estimate() const;
  const vo::Movers& movers() const;
  const StageTimes& times() const;
  // What became of the last frame's features.
  void list_features(std::vector<vo::SeenFeature>& out) const;
  const StereoModel& model() const;
  // Of the last frame, valid until the next process().
  ImageView<const std::uint8_t> rectified_left() const;
  ImageView<const std::uint8_t> rectified_right() const;
  ImageView<const std::int16_t> disparity() const;
  // Where features may be: 0 = not there; empty = everywhere.
  ImageView<const std::uint8_t> mask() const;

 private:
  struct Impl;
  explicit FramePipeline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
