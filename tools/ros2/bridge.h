// SPDX-License-Identifier: BSD-3-Clause
// VO_ODOMETRY, VO_IMAGES and VO_POINTS to ROS 2's topics.
#pragma once

#include <cstdint>
#include <memory>

#include <cliquevo/images_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"

namespace cliquevo::ros2 {

struct BridgeOptions {
  std::uint32_t domain = 0;
  bool images = false;  // /stereo/left/image_rect and /stereo/disparity
  bool points = false;  // /stereo/points2
  RigidTransform T_body_camera;
};

class Bridge {
 public:
  static Result<Bridge> start(const BridgeOptions& options);
  Bridge(Bridge&&) noexcept;
  Bridge& operator=(Bridge&&) noexcept;
  ~Bridge();

  // /odom, /tf, /diagnostics.
  void publish(const odometry_t& m);
  // The disparity as 32FC1, in px; NaN where it is unknown.
  void publish(const images_t& m);
  void publish(const points_t& m);

 private:
  struct Impl;
  explicit Bridge(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::ros2
