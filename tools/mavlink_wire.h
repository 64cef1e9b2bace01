// SPDX-License-Identifier: BSD-3-Clause
// MAVLink 2 frames: the few messages that a visual odometry sends, and those that it answers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace cliquevo::tools::mavlink {

struct Odometry {  // 331
  std::uint64_t time_usec = 0;
  std::array<float, 3> position{};
  std::array<float, 4> q{};  // w x y z
  std::array<float, 3> velocity{};
  std::array<float, 3> rates{};
  std::array<float, 21> pose_covariance{};  // upper triangle by rows: x y z roll pitch yaw
  std::array<float, 21> velocity_covariance{};
  std::uint8_t frame_id = 20;        // MAV_FRAME_LOCAL_FRD
  std::uint8_t child_frame_id = 12;  // MAV_FRAME_BODY_FRD
  std::uint8_t reset_counter = 0;
  std::uint8_t estimator_type = 2;  // MAV_ESTIMATOR_TYPE_VISION
  std::int8_t quality = 0;          // -1 failed, 0 unknown, 1 to 100
};

struct VisionPosition {  // 102, VISION_POSITION_ESTIMATE
  std::uint64_t usec = 0;
  std::array<float, 3> position{};
  std::array<float, 3> roll_pitch_yaw{};
  std::array<float, 21> covariance{};
  std::uint8_t reset_counter = 0;
};

struct TimeSync {  // 111
  std::int64_t tc1 = 0;
  std::int64_t ts1 = 0;
};

// Who sends, and how many frames it has sent.
class Sender {
 public:
  Sender(std::uint8_t system, std::uint8_t component) : system_(system), component_(component) {}

  std::vector<std::uint8_t> heartbeat(bool active);
  std::vector<std::uint8_t> odometry(const Odometry& m);
  std::vector<std::uint8_t> vision_position(const VisionPosition& m);
  std::vector<std::uint8_t> timesync(const TimeSync& m);

 private:
  std::vector<std::uint8_t> frame(std::uint32_t id, std::uint8_t crc_extra, std::vector<std::uint8_t> payload);

  std::uint8_t system_;
  std::uint8_t component_;
  std::uint8_t sequence_ = 0;
};

// Finds the frames in what comes in, of MAVLink 1 and 2, whatever lies between them.
class Receiver {
 public:
  // on_timesync gets every whole TIMESYNC.
  void add(std::span<const std::uint8_t> bytes, const std::function<void(const TimeSync&)>& on_timesync);

 private:
  std::vector<std::uint8_t> pending_;
};

}  // namespace cliquevo::tools::mavlink
