// SPDX-License-Identifier: BSD-3-Clause
// Colour pictures to look at.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"

namespace cliquevo::tools {

struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  bool operator==(const Color&) const = default;
};

class Picture {
 public:
  Picture() = default;
  Picture(int width, int height, Color color);

  int width() const { return bytes_.width() / 3; }
  int height() const { return bytes_.height(); }
  bool empty() const { return bytes_.empty(); }
  Color at(int x, int y) const {
    const std::uint8_t* p = bytes_.view().row(y) + 3 * x;
    return {p[0], p[1], p[2]};
  }
  void set(int x, int y, Color color) {
    std::uint8_t* p = bytes_.view().row(y) + 3 * x;
    p[0] = color.red, p[1] = color.green, p[2] = color.blue;
  }
  // Another picture into this one, as far as it lies inside.
  void put(const Picture& other, int left, int top);
  // Smaller, each pixel the mean of those it covers.
  Picture shrunk(int width, int height) const;
  Result<std::vector<unsigned char>> png() const;

 private:
  Image<std::uint8_t> bytes_;  // red, green, blue, ...
};

// A rainbow from dark blue (0) to dark red (1) whose steps look even.
Color rainbow(double value);

}  // namespace cliquevo::tools
