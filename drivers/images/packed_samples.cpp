// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/packed_samples.h"

namespace cliquevo::drivers {

namespace {

std::size_t bits_of(PackedSamples kind) {
  switch (kind) {
    case PackedSamples::mipi_10:
    case PackedSamples::big_endian_10:
    case PackedSamples::pfnc_10:
      return 10;
    case PackedSamples::mipi_12:
    case PackedSamples::gige_10_or_12:
    case PackedSamples::pfnc_12:
      break;
  }
  return 12;
}

// Upper 8 bits of sample i behind `data`.
std::uint8_t sample(PackedSamples kind, const std::uint8_t* data, std::size_t i) {
  switch (kind) {
    case PackedSamples::mipi_10:
      return data[i / 4 * 5 + i % 4];
    case PackedSamples::mipi_12:
      return data[i / 2 * 3 + i % 2];
    case PackedSamples::gige_10_or_12:
      return data[i / 2 * 3 + i % 2 * 2];
    case PackedSamples::big_endian_10: {
      const std::size_t bit = 10 * i;
      const unsigned two = static_cast<unsigned>(data[bit / 8]) << 8U | data[bit / 8 + 1];
      return static_cast<std::uint8_t>(two >> (8 - bit % 8));
    }
    case PackedSamples::pfnc_10:
    case PackedSamples::pfnc_12: {
      const std::size_t bits = bits_of(kind);
      const std::size_t bit = bits * i;
      const unsigned two = static_cast<unsigned>(data[bit / 8]) | static_cast<unsigned>(data[bit / 8 + 1]) << 8U;
      return static_cast<std::uint8_t>(two >> (bit % 8 + bits - 8));
    }
  }
  return 0;
}

std::size_t bytes_of(PackedSamples kind, std::size_t count) { return (count * bits_of(kind) + 7) / 8; }

}  // namespace

bool unpack_samples(PackedSamples kind, const std::uint8_t* data, std::size_t size, std::size_t stride,
                    ImageView<std::uint8_t> out) {
  const auto width = static_cast<std::size_t>(out.width);
  const auto height = static_cast<std::size_t>(out.height);
  const std::size_t row = bytes_of(kind, width);
  const bool fits =
      stride == 0 ? bytes_of(kind, width * height) <= size : stride >= row && (height - 1) * stride + row <= size;
  if (out.empty() || !fits) return false;
  for (int y = 0; y < out.height; ++y) {
    const std::uint8_t* from = data + stride * static_cast<std::size_t>(y);
    const std::size_t first = stride == 0 ? width * static_cast<std::size_t>(y) : 0;
    std::uint8_t* to = out.row(y);
    for (std::size_t x = 0; x < width; ++x) to[x] = sample(kind, from, first + x);
  }
  return true;
}

}  // namespace cliquevo::drivers
