// SPDX-License-Identifier: BSD-3-Clause
// What viewers of ROS 2's messages get: the topics, and the last messages of each. Nothing waits for a viewer: one that
// is slow finds older messages gone, and goes on with those that are there.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace cliquevo::view {

enum class Topic : std::uint32_t { odom, pose, tf, tf_static, diagnostics, left, camera_info, disparity, points, path };
inline constexpr std::size_t kTopics = 10;

struct TopicInfo {
  const char* name;     // "/odom"
  const char* package;  // "nav_msgs"
  const char* type;     // "Odometry"
  std::size_t kept;     // so many of the last messages
};
const TopicInfo& topic_info(Topic topic);

class Ros2Topics {
 public:
  struct Message {
    TimestampNs stamp_ns = 0;
    std::shared_ptr<const std::vector<std::uint8_t>> cdr;
  };

  // Any thread, all of them.
  void put(Topic topic, TimestampNs stamp_ns, const std::vector<std::uint8_t>& cdr);
  // Where a new subscriber begins: with the last message, if there is one.
  std::int64_t newest(Topic topic) const;
  // Message number `next`, or the oldest behind it that is still there; `next` moves behind it. Nothing: none is there.
  std::optional<Message> take(Topic topic, std::int64_t& next) const;
  // Whether anybody subscribes: what is costly need not be made for nobody.
  bool wanted(Topic topic) const { return subscribers_[index(topic)].load(std::memory_order_relaxed) > 0; }
  void count_subscriber(Topic topic, int change) { subscribers_[index(topic)].fetch_add(change); }

 private:
  static std::size_t index(Topic topic) { return static_cast<std::size_t>(topic); }
  struct Line {
    std::deque<Message> messages;
    std::int64_t first = 0;  // number of the oldest
  };
  mutable std::mutex mutex_;
  std::array<Line, kTopics> lines_;
  std::array<std::atomic<int>, kTopics> subscribers_{};
};

}  // namespace cliquevo::view
