// SPDX-License-Identifier: BSD-3-Clause
// The two working stages of a frame, each to be run by a thread of its own: raw pair -> rectified pair and disparity,
// and on to the estimate. One after the other they are what FramePipeline does.
#pragma once

#include <thread>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/stage_times.h"
#include "drivers/frame_source.h"
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"

namespace cliquevo::daemon {

// What the stereo stage makes of a pair and the odometry stage reads; all of the rectified size.
struct StereoFrame {
  Image<std::uint8_t> left;           // rectified
  Image<std::uint8_t> right;          //
  Image<std::uint8_t> filtered_left;  // the paper's J
  Image<std::int16_t> disparity;      // px * 16
  StageTimes times;
};

class StereoStage {
 public:
  static Result<StereoStage> make(const stereo::StereoParams& params, const drivers::SourceInfo& source,
                                  const stereo::RectifyParams& rectify = {});

  const StereoModel& model() const { return rectifier_.model(); }
  const stereo::Rectifier& rectifier() const { return rectifier_; }
  // Threads that share the stage's work with the caller's.
  std::vector<std::thread::native_handle_type> worker_handles() { return dense_.worker_handles(); }
  // Takes all memory that run() will use.
  void prepare(StereoFrame& frame) const;
  // An Error names unusable input: images of another size than the calibration's. No allocation otherwise.
  Result<void> run(const drivers::StereoPair& pair, StereoFrame& frame);

 private:
  StereoStage(const StereoCalibration& calibration, stereo::Rectifier rectifier, stereo::DenseStereo dense);
  StereoCalibration calibration_;
  stereo::Rectifier rectifier_;
  stereo::DenseStereo dense_;
  Image<std::uint8_t> right_mask_;  // empty = all of it is usable
};

class OdometryStage {
 public:
  static Result<OdometryStage> make(const vo::VoParams& params, const drivers::SourceInfo& source,
                                    const StereoStage& stereo);
  // As vo::VisualOdometry::process(). No allocation after the first frames.
  Result<void> run(TimestampNs stamp_ns, StereoFrame& frame);
  const vo::Estimate& estimate() const { return odometry_.estimate(); }
  const vo::Movers& movers() const { return odometry_.movers(); }
  // Rectified: 0 = no features there; empty = none are left out.
  ImageView<const std::uint8_t> mask() const { return mask_.cview(); }
  void list_features(std::vector<vo::SeenFeature>& out) const { odometry_.list_features(out); }
  void reset() { odometry_.reset(); }

 private:
  explicit OdometryStage(vo::VisualOdometry odometry);
  vo::VisualOdometry odometry_;
  Image<std::uint8_t> mask_;  // empty = all of it is usable
};

}  // namespace cliquevo::daemon
