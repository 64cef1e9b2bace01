// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/stereo_message.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include <cliquevo/images_t.hpp>
#include <fmt/format.h>

#include "drivers/bytes.h"

namespace cliquevo::drivers {

namespace {

constexpr std::string_view kStampKey = "stamp_ns";
constexpr std::string_view kHostKey = "host_ns";

std::int64_t floor_us(std::int64_t ns) { return ns / 1000 - (ns % 1000 < 0 ? 1 : 0); }

void put_metadata(std::vector<std::uint8_t>& out, std::string_view key, std::int64_t value) {
  put_number(out, static_cast<std::int32_t>(key.size() + 1));
  out.insert(out.end(), key.begin(), key.end());
  out.push_back(0);
  put_number(out, std::int32_t{8});
  put_number(out, value);
}

void put_side(std::vector<std::uint8_t>& out, const Image<std::uint8_t>& image, TimestampNs stamp_ns,
              TimestampNs host_ns) {
  put_number(out, floor_us(stamp_ns));
  put_number(out, static_cast<std::int32_t>(image.width()));
  put_number(out, static_cast<std::int32_t>(image.height()));
  put_number(out, static_cast<std::int32_t>(image.width()));
  put_number(out, image_t::PIXEL_FORMAT_GRAY);
  put_number(out, static_cast<std::int32_t>(image.width() * image.height()));
  const ImageView<const std::uint8_t> view = image.cview();
  for (int y = 0; y < view.height; ++y) out.insert(out.end(), view.row(y), view.row(y) + view.width);
  put_number(out, std::int32_t{host_ns != 0 ? 2 : 1});
  put_metadata(out, kStampKey, stamp_ns);
  if (host_ns != 0) put_metadata(out, kHostKey, host_ns);
}

// A damaged log may hold any number: the difference of two such stamps still is one.
TimestampNs bounded(std::int64_t ns) { return std::clamp(ns, -INT64_MAX / 2, INT64_MAX / 2); }

std::string_view text(ByteReader& reader) {
  const auto length = reader.number<std::int32_t>();
  const std::uint8_t* bytes = length > 0 ? reader.bytes(static_cast<std::size_t>(length)) : nullptr;
  return bytes == nullptr
             ? std::string_view{}
             : std::string_view(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(length - 1));
}

Error unusable(const std::string& name, const std::string& why) { return {"cannot use stereo message", name, why}; }

void read_metadata(ByteReader& reader, StereoMessageSide& side) {
  const auto count = reader.number<std::int32_t>();
  for (std::int32_t i = 0; i < count && reader.ok(); ++i) {
    const std::string_view key = text(reader);
    const auto length = reader.number<std::int32_t>();
    const std::uint8_t* value = length >= 0 ? reader.bytes(static_cast<std::size_t>(length)) : nullptr;
    if (value == nullptr || length != 8) continue;
    const auto number = ByteReader(value, 8).number<std::int64_t>();
    if (key == kStampKey) side.stamp_ns = bounded(number);
    if (key == kHostKey) side.host_ns = bounded(number);
  }
}

Result<StereoMessageSide> read_side(ByteReader& reader, const std::string& name) {
  StereoMessageSide side;
  side.stamp_ns = reader.number<std::int64_t>();
  if (side.stamp_ns > INT64_MAX / 1000 || side.stamp_ns < INT64_MIN / 1000)
    return unusable(name, "its stamp is absurd");
  side.stamp_ns = bounded(side.stamp_ns * 1000);
  const auto width = reader.number<std::int32_t>();
  const auto height = reader.number<std::int32_t>();
  const auto stride = reader.number<std::int32_t>();
  const auto format = reader.number<std::int32_t>();
  const auto size = reader.number<std::int32_t>();
  if (!reader.ok() || size < 0) return unusable(name, "it is torn: record again");
  const std::uint8_t* pixels = reader.bytes(static_cast<std::size_t>(size));
  read_metadata(reader, side);
  if (!reader.ok() || pixels == nullptr) return unusable(name, "it is torn: record again");
  if (format == image_t::PIXEL_FORMAT_MJPEG) {
    side.jpeg = pixels;
    side.jpeg_size = static_cast<std::size_t>(size);
    return side;
  }
  if (format != image_t::PIXEL_FORMAT_GRAY) {
    return unusable(name, fmt::format("its pixel format is {}: record grey images of 8 bits ({}) or JPEG ({})", format,
                                      image_t::PIXEL_FORMAT_GRAY, image_t::PIXEL_FORMAT_MJPEG));
  }
  if (width <= 0 || height <= 0 || stride < width || width > 65536 || height > 65536 ||
      std::int64_t{stride} * (height - 1) + width > size) {
    return unusable(name, fmt::format("an image of {}x{} does not fit its {} bytes", width, height, size));
  }
  side.image = {pixels, width, height, stride};
  return side;
}

}  // namespace

void encode_stereo(const StereoPair& pair, std::vector<std::uint8_t>& out) {
  out.clear();
  put_number(out, images_t::getHash());
  put_number(out, floor_us(pair.stamp_ns));
  put_number(out, std::int32_t{2});
  put_number(out, images_t::LEFT);
  put_number(out, images_t::RIGHT);
  put_side(out, pair.left, pair.stamp_ns, pair.host_ns);
  put_side(out, pair.right, pair.stamp_ns + pair.right_offset_ns, 0);
}

StereoMessageStart parse_stereo_start(const std::uint8_t* data, std::size_t size) {
  ByteReader reader(data, size);
  StereoMessageStart start;
  if (reader.number<std::int64_t>() != images_t::getHash()) return start;
  const auto utime = reader.number<std::int64_t>();
  if (!reader.ok() || utime > INT64_MAX / 1000 || utime < INT64_MIN / 1000) return start;
  start.utime = utime;
  const auto count = reader.number<std::int32_t>();
  if (count < 1 || count > 64 || reader.number<std::int16_t>() != images_t::LEFT) return start;
  reader.bytes(2 * static_cast<std::size_t>(count - 1));
  reader.number<std::int64_t>();
  reader.bytes(4 * sizeof(std::int32_t));
  const auto pixels = reader.number<std::int32_t>();
  if (reader.ok() && pixels >= 0) start.metadata_at = static_cast<std::int64_t>(size - reader.left()) + pixels;
  return start;
}

std::optional<TimestampNs> parse_stereo_stamp(const std::uint8_t* metadata, std::size_t size) {
  ByteReader reader(metadata, size);
  StereoMessageSide side;
  side.stamp_ns = INT64_MIN;
  read_metadata(reader, side);
  return side.stamp_ns == INT64_MIN ? std::nullopt : std::optional(side.stamp_ns);
}

bool is_stereo_message(const std::uint8_t* data, std::size_t size) {
  ByteReader reader(data, size);
  if (reader.number<std::int64_t>() != images_t::getHash()) return false;
  reader.number<std::int64_t>();
  const auto count = reader.number<std::int32_t>();
  bool left = false;
  bool right = false;
  for (std::int32_t i = 0; i < std::min(count, 64); ++i) {
    const auto type = reader.number<std::int16_t>();
    left = left || (reader.ok() && type == images_t::LEFT);
    right = right || (reader.ok() && type == images_t::RIGHT);
  }
  return left && right;
}

Result<StereoMessage> parse_stereo(const std::uint8_t* data, std::size_t size, const std::string& name) {
  ByteReader reader(data, size);
  if (reader.number<std::int64_t>() != images_t::getHash()) {
    return unusable(name, "it is of another type than images_t: name a log of stereo pairs");
  }
  reader.number<std::int64_t>();
  const auto count = reader.number<std::int32_t>();
  if (!reader.ok() || count < 0 || count > 64) return unusable(name, "it is torn: record again");
  std::array<std::int16_t, 64> types{};
  for (std::int32_t i = 0; i < count; ++i) types[static_cast<std::size_t>(i)] = reader.number<std::int16_t>();
  std::optional<StereoMessageSide> left;
  std::optional<StereoMessageSide> right;
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int16_t type = types[static_cast<std::size_t>(i)];
    auto side = read_side(reader, name);
    if (!side) return side.error();
    if (type == images_t::LEFT) left = *side;
    if (type == images_t::RIGHT) right = *side;
  }
  if (!left || !right) return unusable(name, "it lacks the left or the right image");
  return StereoMessage{*left, *right};
}

}  // namespace cliquevo::drivers
