// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the stereo stage behind one table. All of it is integer work and bit for bit the same on every
// instruction set; reference.cpp says in plain words what each entry does.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/isa.h"

namespace cliquevo::stereo::kernels {

// Where a rectified pixel comes from: between (x, y) and (x + 1, y + 1) of the raw image.
struct RemapPixel {
  static constexpr int kFraction = 64;  // steps between two raw pixels
  std::int16_t x = -1;                  // < 0: no source
  std::int16_t y = -1;
  std::uint8_t weight_x = 0;  // of column x + 1, 0..64
  std::uint8_t weight_y = 0;  // of row y + 1, 0..64
};

// Matching images carry margins of `kMargin` neutral pixels on both sides of a row, so that vectors may run over the
// ends of a row; what lies there never decides anything.
inline constexpr int kMargin = 320;

// Column sums of absolute differences are 8-bit: window * 2 * range must fit.
constexpr int matching_range(int window, int cap) { return cap < 127 / window ? cap : 127 / window; }
// Disparities are handled in groups of 32.
constexpr int padded_disparities(int num_disparities) { return (num_disparities + 31) / 32 * 32; }

// What the matcher finds for each pixel of a row: costs are sums of absolute differences over the window.
struct MatchRow {
  std::int16_t* disparity;  // px; kUnknownDisparity where no window fits or the best one ends the range
  std::uint16_t* best;      // cost at `disparity`; the three below are only set where it is known
  std::uint16_t* below;     // cost at disparity - 1
  std::uint16_t* above;     // cost at disparity + 1
  std::uint16_t* second;    // lowest cost more than 1 px away, 65535 if there is none
};

struct MatchJob {
  const std::uint8_t* left;   // matching images: pixel (0, 0); values 0 .. 2 * range
  const std::uint8_t* right;  // of the same stride
  std::ptrdiff_t stride;
  int width;
  int height;
  int window;
  int min_disparity;
  int num_disparities;
  int y;                  // the row to match; rows beyond the image are its first or last row again
  bool first;             // whether `columns` must be built anew; otherwise they are those of row y - 1
  std::uint8_t* columns;  // width * padded_disparities, kept between rows
  std::uint16_t* costs;   // width * padded_disparities (the vector kernels use a part)
  MatchRow out;
};

struct Table {
  Isa isa;
  // out[i] = bilinear sample of raw at map[i], 0 where there is no source.
  void (*remap_row)(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapPixel* map, int width,
                    std::uint8_t* out);
  // x-Sobel of a row given its neighbours: filtered = clip(sobel, +-cap) + cap;
  // matching = round(clip(sobel, +-cap) * scale / 2^15) + range. The first and last column are neutral.
  void (*prefilter_row)(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int width,
                        int cap, int scale, int range, std::uint8_t* filtered, std::uint8_t* matching);
  void (*match_row)(const MatchJob& job);
};

// The table for an instruction set this build has; the reference's otherwise.
const Table& table(Isa isa);
// The one for active_isa().
const Table& active();

extern const Table kReference;
extern const Table kSse4;
extern const Table kAvx2;
extern const Table kNeon;

}  // namespace cliquevo::stereo::kernels
