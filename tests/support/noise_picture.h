// SPDX-License-Identifier: BSD-3-Clause
// A picture of smooth random spots, as a camera sees it that was moved.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/image.h"

namespace cliquevo::test {

// `shift`: px to the left, `down`: px lower.
inline Image<std::uint8_t> noise_picture(int width, int height, double shift, double down) {
  Image<std::uint8_t> out(width, height);
  const auto noise = [](int x, int y) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x9E3779B9U + static_cast<std::uint32_t>(y) * 0x85EBCA6BU;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    return static_cast<double>((h ^ (h >> 13U)) & 255U);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + shift) / 6.0 + 100.0;
      const double v = (y - down) / 6.0 + 100.0;
      const int i = static_cast<int>(std::floor(u));
      const int j = static_cast<int>(std::floor(v));
      const double a = u - i;
      const double b = v - j;
      out.view()(x, y) = static_cast<std::uint8_t>((1 - b) * ((1 - a) * noise(i, j) + a * noise(i + 1, j)) +
                                                   b * ((1 - a) * noise(i, j + 1) + a * noise(i + 1, j + 1)));
    }
  }
  return out;
}

}  // namespace cliquevo::test
