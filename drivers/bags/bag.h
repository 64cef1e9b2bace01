// SPDX-License-Identifier: BSD-3-Clause
// A bag as a list of messages, whatever its container: .mcap, ROS 1's .bag, rosbag2's .db3.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

enum class Serialization { cdr, ros1, other };

struct BagTopic {
  std::string name;  // "/stereo/left/image_raw"
  std::string type;  // "sensor_msgs/Image", also of ROS 2's sensor_msgs/msg/Image
  Serialization serialization = Serialization::other;
  std::string definition;  // of the type, where the container has it
};

// Where a message is.
struct BagMessage {
  TimestampNs received_ns = 0;  // as the container has it
  std::uint64_t at = 0;         // offset in the chunk; number of the row
  std::uint32_t topic = 0;      // index into topics()
  std::int32_t chunk = -1;      // -1: in the file itself
};

class Bag {
 public:
  virtual ~Bag() = default;

  const std::vector<BagTopic>& topics() const { return topics_; }
  // In the order in which they were written.
  const std::vector<BagMessage>& messages() const { return messages_; }
  // What is wrong with a bag that can be read all the same, as a phrase; empty = nothing.
  const std::string& damage() const { return damage_; }
  const std::string& path() const { return path_; }
  // "ROS 2 bag (MCAP)", ...
  virtual std::string kind() const = 0;
  // The message's bytes, at most `most` of them. One thread at a time.
  virtual Result<void> read(const BagMessage& message, std::vector<std::uint8_t>& out, std::size_t most = SIZE_MAX) = 0;

 protected:
  // The number of this topic, which is added where it is new.
  std::uint32_t topic_number(BagTopic topic);

  std::string path_;
  std::vector<BagTopic> topics_;
  std::vector<BagMessage> messages_;
  std::string damage_;
};

// Whether the file begins as one of these containers does.
bool looks_like_bag(const std::string& path);
// An error where the file is none, or so damaged that no message is left.
Result<std::unique_ptr<Bag>> open_bag(const std::string& path);

// Each container.
Result<std::unique_ptr<Bag>> open_mcap(const std::string& path);
Result<std::unique_ptr<Bag>> open_ros1_bag(const std::string& path);
Result<std::unique_ptr<Bag>> open_sqlite_bag(const std::string& path);

// "sensor_msgs/msg/Image" and "sensor_msgs/Image" are one type.
std::string plain_type(const std::string& name);

// More messages than this are an error: no bag holds them, a damaged one may claim to.
inline constexpr std::size_t kMostBagMessages = 50'000'000;

}  // namespace cliquevo::drivers
