// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/ros_messages.h"

#include <algorithm>
#include <bit>

namespace cliquevo::drivers {

namespace {

// Numbers, texts and arrays of a message. CDR aligns each to its own size, counted from behind four bytes that give
// the byte order; ROS 1 does neither.
class FieldReader {
 public:
  FieldReader(MessageBytes bytes, Serialization form) : bytes_(bytes) {
    if (form == Serialization::other) ok_ = false;
    if (form != Serialization::cdr) return;
    aligned_ = true;
    // 0, 1: CDR; 6, 7: the plain form of XCDR 2, which aligns to four bytes at most. Odd: the lowest byte first.
    const bool known = bytes.size() >= 4 && bytes[0] == 0 && (bytes[1] <= 1 || bytes[1] == 6 || bytes[1] == 7);
    if (!known) {
      ok_ = false;
      return;
    }
    little_ = bytes[1] % 2 == 1;
    most_aligned_ = bytes[1] >= 6 ? 4 : 8;
    bytes_ = bytes.subspan(4);
  }

  bool ok() const { return ok_; }
  template <typename T>
  T number() {
    align(sizeof(T));
    std::uint64_t bits = 0;
    const MessageBytes from = take(sizeof(T));
    for (std::size_t i = 0; i < from.size(); ++i) bits = bits << 8U | from[little_ ? from.size() - 1 - i : i];
    if constexpr (std::is_same_v<T, double>) {
      return std::bit_cast<double>(bits);
    } else {
      return static_cast<T>(bits);
    }
  }
  std::string_view text() {
    const MessageBytes from = take(number<std::uint32_t>());
    std::string_view out(reinterpret_cast<const char*>(from.data()), from.size());
    if (aligned_ && !out.empty() && out.back() == '\0') out.remove_suffix(1);
    return out;
  }
  MessageBytes block() { return take(number<std::uint32_t>()); }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  void align(std::size_t size) {
    const std::size_t to = std::min(size, most_aligned_);
    if (aligned_ && at_ % to != 0) take(to - at_ % to);
  }
  MessageBytes take(std::size_t count) {
    if (!ok_ || count > left()) {
      ok_ = false;
      return {};
    }
    const MessageBytes out = bytes_.subspan(at_, count);
    at_ += count;
    return out;
  }

  MessageBytes bytes_;
  std::size_t at_ = 0;
  bool aligned_ = false;
  bool little_ = true;
  std::size_t most_aligned_ = 8;
  bool ok_ = true;
};

TimestampNs read_stamp(FieldReader& reader, Serialization form) {
  if (form == Serialization::ros1) reader.number<std::uint32_t>();  // its number
  const auto seconds = form == Serialization::ros1 ? static_cast<std::int64_t>(reader.number<std::uint32_t>())
                                                   : static_cast<std::int64_t>(reader.number<std::int32_t>());
  return seconds * 1'000'000'000 + static_cast<std::int64_t>(reader.number<std::uint32_t>());
}

RosHeader read_header(FieldReader& reader, Serialization form) {
  RosHeader header;
  header.stamp_ns = read_stamp(reader, form);
  header.frame_id = reader.text();
  return header;
}

template <std::size_t N>
void read_all(FieldReader& reader, std::array<double, N>& out) {
  for (double& value : out) value = reader.number<double>();
}

}  // namespace

std::optional<RosImage> parse_image(MessageBytes bytes, Serialization form) {
  FieldReader reader(bytes, form);
  RosImage out;
  out.header = read_header(reader, form);
  out.height = reader.number<std::uint32_t>();
  out.width = reader.number<std::uint32_t>();
  out.encoding = reader.text();
  out.big_endian = reader.number<std::uint8_t>() != 0;
  out.step = reader.number<std::uint32_t>();
  out.data = reader.block();
  if (!reader.ok()) return std::nullopt;
  return out;
}

std::optional<RosCompressedImage> parse_compressed_image(MessageBytes bytes, Serialization form) {
  FieldReader reader(bytes, form);
  RosCompressedImage out;
  out.header = read_header(reader, form);
  out.format = reader.text();
  out.data = reader.block();
  if (!reader.ok()) return std::nullopt;
  return out;
}

std::optional<RosCameraInfo> parse_camera_info(MessageBytes bytes, Serialization form) {
  FieldReader reader(bytes, form);
  RosCameraInfo out;
  out.header = read_header(reader, form);
  out.height = reader.number<std::uint32_t>();
  out.width = reader.number<std::uint32_t>();
  out.distortion_model = reader.text();
  const auto count = reader.number<std::uint32_t>();
  if (count > reader.left() / sizeof(double)) return std::nullopt;
  for (std::uint32_t i = 0; i < count; ++i) out.D.push_back(reader.number<double>());
  read_all(reader, out.K);
  read_all(reader, out.R);
  read_all(reader, out.P);
  out.binning_x = reader.number<std::uint32_t>();
  out.binning_y = reader.number<std::uint32_t>();
  if (!reader.ok()) return std::nullopt;
  return out;
}

std::optional<TimestampNs> parse_stamp(MessageBytes beginning, Serialization form) {
  FieldReader reader(beginning, form);
  const TimestampNs stamp_ns = read_stamp(reader, form);
  if (!reader.ok()) return std::nullopt;
  return stamp_ns;
}

}  // namespace cliquevo::drivers
