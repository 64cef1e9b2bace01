// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/ros2_topics.h"

#include <algorithm>

namespace cliquevo::view {

const TopicInfo& topic_info(Topic topic) {
  // Of what comes with every frame two seconds and more at 30 Hz; of pictures, which are large, the last two.
  static constexpr std::array<TopicInfo, kTopics> kInfos{{{"/odom", "nav_msgs", "Odometry", 64},
                                                          {"/pose", "geometry_msgs", "PoseStamped", 64},
                                                          {"/tf", "tf2_msgs", "TFMessage", 64},
                                                          {"/tf_static", "tf2_msgs", "TFMessage", 1},
                                                          {"/diagnostics", "diagnostic_msgs", "DiagnosticArray", 64},
                                                          {"/stereo/left/image_rect", "sensor_msgs", "Image", 2},
                                                          {"/stereo/left/camera_info", "sensor_msgs", "CameraInfo", 2},
                                                          {"/stereo/disparity", "sensor_msgs", "Image", 2},
                                                          {"/stereo/points2", "sensor_msgs", "PointCloud2", 2},
                                                          {"/path", "sensor_msgs", "PointCloud2", 1}}};
  return kInfos[static_cast<std::size_t>(topic)];
}

void Ros2Topics::put(Topic topic, TimestampNs stamp_ns, const std::vector<std::uint8_t>& cdr) {
  Message message{stamp_ns, std::make_shared<const std::vector<std::uint8_t>>(cdr)};
  const std::lock_guard lock(mutex_);
  Line& line = lines_[index(topic)];
  line.messages.push_back(std::move(message));
  if (line.messages.size() <= topic_info(topic).kept) return;
  line.messages.pop_front();
  ++line.first;
}

std::int64_t Ros2Topics::newest(Topic topic) const {
  const std::lock_guard lock(mutex_);
  const Line& line = lines_[index(topic)];
  return line.first + std::max<std::int64_t>(0, std::ssize(line.messages) - 1);
}

std::optional<Ros2Topics::Message> Ros2Topics::take(Topic topic, std::int64_t& next) const {
  const std::lock_guard lock(mutex_);
  const Line& line = lines_[index(topic)];
  next = std::max(next, line.first);
  const std::int64_t at = next - line.first;
  if (at >= std::ssize(line.messages)) return std::nullopt;
  ++next;
  return line.messages[static_cast<std::size_t>(at)];
}

}  // namespace cliquevo::view
