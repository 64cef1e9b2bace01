// SPDX-License-Identifier: BSD-3-Clause
// Frames that hold their number and camera: a receiver can check every byte.
#pragma once

#include <cstdint>

#include "core/base/image.h"

namespace cliquevo::test {

// The first row is the number; the rest hangs on it, the camera (seed) and the place.
inline std::uint8_t made_up_grey(unsigned number, unsigned seed, unsigned x, unsigned y) {
  if (y == 0) return static_cast<std::uint8_t>(number >> (8 * (x % 4)));
  return static_cast<std::uint8_t>(3 * x + 5 * y + 7 * number + 101 * seed + x * y / 7);
}

inline void make_up_yuyv(unsigned number, unsigned seed, unsigned width, unsigned height, std::uint8_t* out) {
  for (unsigned y = 0; y < height; ++y) {
    for (unsigned x = 0; x < width; ++x) {
      *out++ = made_up_grey(number, seed, x, y);
      *out++ = 128;
    }
  }
}

// The number of the frame, if it is one of that camera's, byte for byte; else -1.
inline std::int64_t number_of(ImageView<const std::uint8_t> image, unsigned seed) {
  if (image.width < 4) return -1;
  const auto byte = [&image](int x) { return static_cast<unsigned>(image(x, 0)); };
  const unsigned number = byte(0) | byte(1) << 8U | byte(2) << 16U | byte(3) << 24U;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image(x, y) != made_up_grey(number, seed, static_cast<unsigned>(x), static_cast<unsigned>(y))) return -1;
    }
  }
  return number;
}

}  // namespace cliquevo::test
