// SPDX-License-Identifier: BSD-3-Clause
// The surfaces' textures: periodic tiles with mip levels, made once a process. Dead-leaves pictures (overlapping shapes
// whose sizes follow a power law) have the statistics of natural images: spectrum, edges and corners.
#pragma once

#include <cstdint>
#include <vector>

namespace cliquevo::drivers::sim {

// Square tile, each level half the size of the one before. A texel holds itself and its right, lower and lower right
// neighbour (bytes 0 to 3), wrapped around: one load gives all that bilinear interpolation needs.
struct Tile {
  static constexpr int kLog2Size = 11;
  static constexpr int kSize = 1 << kLog2Size;
  static constexpr int kLastLevel = 9;
  std::vector<std::uint32_t> quads;  // levels one after the other
};

// Cube of solid texture for rocks and posts, quads in x and y as above.
struct SolidTexture {
  static constexpr int kLog2Size = 6;
  static constexpr int kSize = 1 << kLog2Size;
  static constexpr int kLastLevel = 4;
  std::vector<std::uint32_t> quads;
  std::vector<std::uint32_t> level_start;
};

// What is too far to move: clouds and a line of hills, by azimuth (x, periodic) and rise (z over level distance).
struct Panorama {
  static constexpr int kLog2Width = 13;
  static constexpr int kWidth = 1 << kLog2Width;
  static constexpr int kHeight = 512;
  static constexpr float kLowestRise = -0.1F;
  static constexpr float kRiseSpan = 0.65F;
  std::vector<std::uint32_t> quads;
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
