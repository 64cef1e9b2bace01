// SPDX-License-Identifier: BSD-3-Clause
// VO_POINTS, on a thread of lower priority than all others. The odometry thread gives it images and the output thread
// sets it to work; neither ever waits for it. It has a connection of its own, as LCM's is locked while a message goes
// out.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "daemon/lcm/publisher.h"
#include "daemon/pipeline/lcm_config.h"

namespace cliquevo::daemon {

class PointsThread {
 public:
  // Null where the configuration names no channel for points.
  static Result<std::unique_ptr<PointsThread>> start(const LcmConfig& config, const StereoModel& model,
                                                     const RigidTransform& T_body_camera);
  ~PointsThread();
  PointsThread(const PointsThread&) = delete;
  PointsThread& operator=(const PointsThread&) = delete;

  // Odometry thread: copies when points are due and the last ones have gone out. No allocation, no lock.
  void offer(TimestampNs stamp_ns, ImageView<const std::uint8_t> left, ImageView<const std::int16_t> disparity);
  // Output thread, after a frame's messages: begins with what was offered, or hands over what is done since to whoever
  // copies messages. false: it could not be sent.
  bool after_frame(Publisher& publisher);
  // Any thread: another rate, more than 0.
  void set_rate(double rate_hz);

 private:
  struct Impl;
  explicit PointsThread(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
