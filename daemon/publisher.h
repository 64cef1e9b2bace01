// SPDX-License-Identifier: BSD-3-Clause
// Estimates out over LCM: VO_DELTA_CAMERA, POSE_BODY and VO_STATUS for every frame.
#pragma once

#include <memory>

#include "core/vo/visual_odometry.h"
#include "daemon/config.h"
#include "daemon/frame_pipeline.h"

namespace cliquevo::daemon {

struct PublishedFrame {
  std::int64_t index = 0;
  vo::Estimate estimate;
  StageTimes times;
  std::int64_t dropped = 0;  // frames skipped so far
  std::int32_t resets = 0;   // rises with every pose reset
};

class Publisher {
 public:
  // Fails when the URL cannot be used (no route, malformed).
  static Result<Publisher> make(const LcmConfig& config, const RigidTransform& T_body_camera);
  Publisher(Publisher&&) noexcept;
  Publisher& operator=(Publisher&&) noexcept;
  ~Publisher();

  // false: a message could not be sent.
  bool publish(const PublishedFrame& frame);

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
