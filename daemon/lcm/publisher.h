// SPDX-License-Identifier: BSD-3-Clause
// Estimates out over LCM: VO_DELTA_CAMERA, POSE_BODY, VO_STATUS and whatever else is configured for every frame,
// VO_HEALTH now and then.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <cliquevo/health_t.hpp>

#include "daemon/lcm/feature_tap.h"
#include "daemon/lcm/image_tap.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/published_frame.h"

namespace cliquevo::daemon {

class Publisher {
 public:
  // Fails when the URL cannot be used (no route, malformed).
  static Result<Publisher> make(const LcmConfig& config, const RigidTransform& T_body_camera);
  Publisher(Publisher&&) noexcept;
  Publisher& operator=(Publisher&&) noexcept;
  ~Publisher();

  // Gets a copy of every message that is sent, on the sending thread.
  using Copy = std::function<void(const std::string& channel, const std::uint8_t* data, std::size_t size)>;
  void copy_to(Copy copy);
  // false: a message could not be sent.
  bool publish(const PublishedFrame& frame);
  // VO_IMAGES, from the thread that publishes frames.
  bool publish(const TappedImages& images, const StereoModel& model);
  // VO_FEATURES, likewise.
  bool publish(const TappedFeatures& features, const StereoModel& model);
  // A message that was encoded elsewhere, from the thread that publishes frames: to whoever gets copies, and, where
  // `send`, out.
  bool pass_on(const std::string& channel, const std::uint8_t* data, std::size_t size, bool send);
  // VO_HEALTH; may be called from another thread than the one above.
  bool publish(const health_t& health);

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
