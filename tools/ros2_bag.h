// SPDX-License-Identifier: BSD-3-Clause
// A new MCAP with the topics that ROS 2's tools know: images, calibration, odometry, transforms, the path, diagnostics.
#pragma once

#include <memory>
#include <string>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/pose_t.hpp>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

// How the bag holds images: `png` is lossless, takes somewhat less room and some of a processor.
enum class BagImages { plain, png };

class Ros2Bag {
 public:
  static Result<Ros2Bag> create(const std::string& path, const drivers::SourceInfo& info,
                                const RigidTransform& T_body_camera, BagImages images = BagImages::plain);
  Ros2Bag(Ros2Bag&&) noexcept;
  Ros2Bag& operator=(Ros2Bag&&) noexcept;
  ~Ros2Bag();

  Result<void> add(const drivers::StereoPair& pair);
  Result<void> add(const odometry_t& m);
  // Of logs without odometry_t: without covariance, so as pose and transform alone.
  Result<void> add(const pose_t& m);
  Result<void> add(const points_t& m);
  Result<void> finish();
  std::int64_t bytes() const;

 private:
  struct Impl;
  explicit Ros2Bag(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::tools
