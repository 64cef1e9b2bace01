// SPDX-License-Identifier: BSD-3-Clause
// Big-endian numbers in messages and event logs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace cliquevo::drivers {

template <typename T>
void put_number(std::vector<std::uint8_t>& out, T value) {
  const auto bits = static_cast<std::uint64_t>(value);
  for (std::size_t i = sizeof(T); i-- > 0;) out.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
}

// Takes numbers off the front; what is not there any more reads as 0 and leaves ok() false.
class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  bool ok() const { return ok_; }
  std::size_t left() const { return left_; }
  template <typename T>
  T number() {
    std::uint64_t bits = 0;
    const std::uint8_t* p = bytes(sizeof(T));
    for (std::size_t i = 0; p != nullptr && i < sizeof(T); ++i) bits = bits << 8U | p[i];
    return static_cast<T>(bits);
  }
  // nullptr: not so many left.
  const std::uint8_t* bytes(std::size_t count) {
    if (!ok_ || count > left_) {
      ok_ = false;
      return nullptr;
    }
    const std::uint8_t* at = data_;
    data_ += count;
    left_ -= count;
    return at;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
  bool ok_ = true;
};

}  // namespace cliquevo::drivers
