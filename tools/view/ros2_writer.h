// SPDX-License-Identifier: BSD-3-Clause
// A feed's messages as ROS 2's, for viewers; by the thread that feeds.
#pragma once

#include <optional>

#include <cliquevo/images_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "daemon/ros2/thinned_path.h"
#include "drivers/bags/cdr_writer.h"
#include "tools/view/ros2_topics.h"

namespace cliquevo::view {

class Ros2Writer {
 public:
  Ros2Writer(Ros2Topics& topics, const RigidTransform& T_body_camera);

  // How the camera sits on the body, as is known now.
  void mount(const RigidTransform& T_body_camera);
  void add(const odometry_t& m);
  // Those below are made only where somebody subscribes.
  void add(const points_t& m);
  void add_left(TimestampNs stamp_ns, ImageView<const std::uint8_t> left, const std::optional<StereoModel>& model);
  void add_disparity(TimestampNs stamp_ns, ImageView<const std::int16_t> disparity);
  bool wants_points() const { return topics_.wanted(Topic::points); }

 private:
  void put(Topic topic, TimestampNs stamp_ns) { topics_.put(topic, stamp_ns, cdr_.bytes()); }

  Ros2Topics& topics_;
  RigidTransform T_body_camera_;
  drivers::CdrWriter cdr_;
  ros2::ThinnedPath path_;
  TimestampNs path_ns_ = 0;  // of the path that was put last
  TimestampNs last_ns_ = 0;  // of the last odometry
};

// The camera that VO_IMAGES describes; none where it describes none that can be.
std::optional<StereoModel> camera_of(const image_t& image);

}  // namespace cliquevo::view
