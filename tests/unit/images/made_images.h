// SPDX-License-Identifier: BSD-3-Clause
// Image files made byte by byte, independently of the libraries that read them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drivers/images/decode_image.h"

namespace cliquevo::test {

using File = std::vector<std::uint8_t>;

struct PngKind {
  int width = 13;
  int height = 11;
  int depth = 8;
  int color_type = 0;  // 0 grey, 2 RGB, 3 palette, 4 grey with alpha, 6 RGB with alpha
  bool interlaced = false;
  std::vector<std::uint8_t> palette;  // red, green, blue
  std::uint32_t claimed_width = 0;    // what the header claims; 0 = the truth
  std::uint32_t claimed_height = 0;
};
// sample(x, y, channel) is as stored.
File make_png(const PngKind& kind, const std::function<unsigned(int x, int y, int channel)>& sample);

// Little-endian numbers.
void put16(File& file, unsigned value);
void put32(File& file, std::uint32_t value);

File read_bytes(const std::string& path);
drivers::Bytes bytes_of(const std::string& text);

}  // namespace cliquevo::test
