// SPDX-License-Identifier: BSD-3-Clause
// The messages that stereo needs, as ROS 1 and ROS 2 (CDR) serialise them. Views into the bytes they were read from.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "drivers/bags/bag.h"

namespace cliquevo::drivers {

inline constexpr const char* kImageType = "sensor_msgs/Image";
inline constexpr const char* kCompressedImageType = "sensor_msgs/CompressedImage";
inline constexpr const char* kCameraInfoType = "sensor_msgs/CameraInfo";

struct RosHeader {
  TimestampNs stamp_ns = 0;
  std::string_view frame_id;
};

struct RosImage {
  RosHeader header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string_view encoding;
  bool big_endian = false;
  std::uint32_t step = 0;
  std::span<const std::uint8_t> data;
};

struct RosCompressedImage {
  RosHeader header;
  std::string_view format;
  std::span<const std::uint8_t> data;
};

struct RosCameraInfo {
  RosHeader header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 9> R{};
  std::array<double, 12> P{};
  std::uint32_t binning_x = 0;
  std::uint32_t binning_y = 0;
};

using MessageBytes = std::span<const std::uint8_t>;
// Nothing where the bytes are no such message.
std::optional<RosImage> parse_image(MessageBytes bytes, Serialization form);
std::optional<RosCompressedImage> parse_compressed_image(MessageBytes bytes, Serialization form);
std::optional<RosCameraInfo> parse_camera_info(MessageBytes bytes, Serialization form);
// The stamp of a header at a message's beginning, for which kStampBytes of it are enough.
inline constexpr std::size_t kStampBytes = 16;
std::optional<TimestampNs> parse_stamp(MessageBytes beginning, Serialization form);

}  // namespace cliquevo::drivers
