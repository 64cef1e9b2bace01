// SPDX-License-Identifier: BSD-3-Clause
// The two working stages of a frame, each to be run by a thread of its own: raw pair -> rectified pair and disparity,
// and on to the estimate. One after the other they are what FramePipeline does.
#pragma once

#include <memory>

#include "core/base/image.h"
#include "core/base/result.h"
#include "core/vo/visual_odometry.h"
#include "daemon/frame_pipeline.h"
#include "daemon/published_frame.h"
#include "drivers/frame_source.h"
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"

namespace cliquevo::daemon {

// A frame on its way. Whoever holds the slot owns all of it.
struct FrameSlot {
  drivers::StereoPair pair;           // by the grabber
  Image<std::uint8_t> left;           // from here on by the stereo stage: rectified
  Image<std::uint8_t> right;          //
  Image<std::uint8_t> filtered_left;  // the paper's J
  Image<std::int16_t> disparity;      // px * 16
  StageTimes times;
  FrameStamps stamps;
  std::int64_t grabbed_mono_ns = 0;  // monotonic_ns() at stamps.grabbed_ns
};

class StereoStage {
 public:
  static Result<StereoStage> make(const stereo::StereoParams& params, const drivers::SourceInfo& source);

  const StereoModel& model() const { return rectifier_.model(); }
  // The source's mask of the left eye on the rectified image; empty when it has none.
  Result<Image<std::uint8_t>> rectified_mask(const drivers::SourceInfo& source) const;
  // Takes all memory that run() will use.
  void prepare(FrameSlot& slot) const;
  // pair -> rectified images, filtered_left, disparity, times. No allocation.
  Result<void> run(FrameSlot& slot);

 private:
  StereoStage(stereo::Rectifier rectifier, stereo::DenseStereo dense);
  stereo::Rectifier rectifier_;
  stereo::DenseStereo dense_;
};

class OdometryStage {
 public:
  static Result<OdometryStage> make(const vo::VoParams& params, const StereoModel& model,
                                    ImageView<const std::uint8_t> left_mask);
  // No allocation after the first frames.
  Result<void> run(FrameSlot& slot);
  const vo::Estimate& estimate() const { return odometry_.estimate(); }
  void reset() { odometry_.reset(); }

 private:
  explicit OdometryStage(vo::VisualOdometry odometry);
  vo::VisualOdometry odometry_;
};

}  // namespace cliquevo::daemon
