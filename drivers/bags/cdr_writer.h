// SPDX-License-Identifier: BSD-3-Clause
// Plain CDR, the lowest byte first, as ROS 2 serialises its messages: each number is aligned to its own size, counted
// from behind the four bytes at the beginning.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace cliquevo::drivers {

class CdrWriter {
 public:
  CdrWriter() { clear(); }

  void clear() { bytes_ = {0, 1, 0, 0}; }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

  template <std::integral T>
  CdrWriter& put(T value) {
    constexpr std::size_t kHead = 4;
    while ((bytes_.size() - kHead) % sizeof(T) != 0) bytes_.push_back(0);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  CdrWriter& put(double value) { return put(std::bit_cast<std::uint64_t>(value)); }
  CdrWriter& put(float value) { return put(std::bit_cast<std::uint32_t>(value)); }
  CdrWriter& put(std::span<const double> values) {
    for (const double value : values) put(value);
    return *this;
  }
  CdrWriter& text(std::string_view value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    bytes_.push_back(0);
    return *this;
  }
  // A sequence of bytes.
  CdrWriter& block(std::span<const std::uint8_t> value) {
    put(static_cast<std::uint32_t>(value.size()));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  // A sequence of bytes, row by row.
  CdrWriter& begin_block(std::size_t size) { return put(static_cast<std::uint32_t>(size)); }
  CdrWriter& row(std::span<const std::uint8_t> value) {
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  // std_msgs/Header
  CdrWriter& header(TimestampNs stamp_ns, std::string_view frame_id) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const std::int64_t rest = ((stamp_ns % kSecond) + kSecond) % kSecond;
    put(static_cast<std::int32_t>((stamp_ns - rest) / kSecond));
    put(static_cast<std::uint32_t>(rest));
    return text(frame_id);
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace cliquevo::drivers
