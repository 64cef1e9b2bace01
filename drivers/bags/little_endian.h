// SPDX-License-Identifier: BSD-3-Clause
// Little-endian numbers, and counted bytes, off the front of a block that may hold anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace cliquevo::drivers {

// What is not there any more reads as 0 or empty and leaves ok() false.
class LittleEndianReader {
 public:
  explicit LittleEndianReader(std::span<const std::uint8_t> data) : data_(data) {}

  bool ok() const { return ok_; }
  std::size_t left() const { return data_.size(); }
  template <typename T>
  T number() {
    std::uint64_t bits = 0;
    const auto from = bytes(sizeof(T));
    for (std::size_t i = from.size(); i-- > 0;) bits = bits << 8U | from[i];
    return static_cast<T>(bits);
  }
  std::span<const std::uint8_t> bytes(std::uint64_t count) {
    if (!ok_ || count > data_.size()) {
      ok_ = false;
      return {};
    }
    const auto out = data_.first(static_cast<std::size_t>(count));
    data_ = data_.subspan(static_cast<std::size_t>(count));
    return out;
  }
  std::string_view text(std::uint64_t count) {
    const auto from = bytes(count);
    return {reinterpret_cast<const char*>(from.data()), from.size()};
  }
  // With its length before it.
  std::string_view text() { return text(number<std::uint32_t>()); }

 private:
  std::span<const std::uint8_t> data_;
  bool ok_ = true;
};

}  // namespace cliquevo::drivers
