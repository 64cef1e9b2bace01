// SPDX-License-Identifier: BSD-3-Clause
// The surfaces' textures: periodic tiles with mip levels, made once a process. Dead-leaves pictures (overlapping shapes
// whose sizes follow a power law) have the statistics of natural images: spectrum, edges and corners.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/simulator/large_array.h"

namespace cliquevo::drivers::sim {

// Square tile, each level half the size of the one before. An element holds a texel and the one below it (wrapped
// around), and the first columns are repeated at the end of a row: one load of two elements gives all four texels that
// bilinear interpolation needs, at half the memory of storing the four for each texel.
struct Tile {
  static constexpr int kLog2Size = 11;
  static constexpr int kSize = 1 << kLog2Size;
  static constexpr int kLastLevel = 9;
  static constexpr int kPadding = 2;
  LargeArray<std::uint16_t> pairs;

  // Level l begins at 2 (4^11 - 4^(11-l)): a shift and no table.
  static std::size_t start(int level) {
    return (std::size_t{2} << (2 * kLog2Size)) - (std::size_t{2} << (2 * (kLog2Size - level)));
  }
};

// Cube of solid texture for rocks and posts, quads in x and y as above.
struct SolidTexture {
  static constexpr int kLog2Size = 6;
  static constexpr int kSize = 1 << kLog2Size;
  static constexpr int kLastLevel = 4;
  LargeArray<std::uint32_t> quads;
  std::vector<std::uint32_t> level_start;
};

// What is too far to move: clouds and a line of hills, by azimuth (x, periodic) and rise (z over level distance).
struct Panorama {
  static constexpr int kLog2Width = 13;
  static constexpr int kWidth = 1 << kLog2Width;
  static constexpr int kHeight = 512;
  static constexpr float kLowestRise = -0.1F;
  static constexpr float kRiseSpan = 0.65F;
  LargeArray<std::uint32_t> quads;
};

struct Textures {
  Tile gravel;  // mean 128, standard deviation about 40
  Tile grass;
  SolidTexture stone;
  Panorama sky;
};

// Built at the first call, which takes some tenths of a second; safe from any thread.
const Textures& textures();

}  // namespace cliquevo::drivers::sim
