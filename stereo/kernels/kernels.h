// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of the stereo stage behind one table. They give the same bits on every instruction set; reference.cpp
// defines what each entry does.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/kernel_tables.h"

namespace cliquevo::stereo::kernels {

// Where the pixels of a rectified row come from: between (x, y) and (x + 1, y + 1) of the raw image.
struct RemapRow {
  static constexpr int kFraction = 64;  // steps between two raw pixels
  static constexpr int kBlock = 8;
  // The patch of 16 x 3 raw pixels that holds all that a block of pixels needs; x < 0: there is none.
  struct Patch {
    static constexpr int kWidth = 16;
    static constexpr int kHeight = 3;
    std::int16_t x, y;
  };

  const std::int16_t* x;  // < 0: no source
  const std::int16_t* y;
  const std::uint8_t* weight_x;  // of column x + 1, 0..64
  const std::uint8_t* weight_y;  // of row y + 1, 0..64
  const Patch* patches;          // one a full block
  const std::uint8_t* at;        // place within the patch: column, and 128 where it is the second row
};

// Rows of matching images carry `kMargin` pixels on both sides, so that vectors may run over their ends; what lies
// there never decides anything.
inline constexpr int kMargin = 384;

// Vectors take 32 disparities at a time.
constexpr int padded_disparities(int num_disparities) { return (num_disparities + 31) / 32 * 32; }
// A cost and the place where it was found share 16 bits ("key"): this many places must be distinguished.
constexpr int key_weight(int num_disparities) {
  int weight = 1;
  while (weight * 8 < padded_disparities(num_disparities)) weight *= 2;
  return weight;
}
// Matching images hold 0 .. 2 * range. The range is as large as the sums allow: 7 bits for a column of the window, 16
// for a key. More than 9 brings nothing (stereo/README.md).
constexpr int matching_range(int window, int window_height, int num_disparities) {
  const int weight = key_weight(num_disparities);
  int range = 63 / window_height < 9 ? 63 / window_height : 9;
  while (range > 1 && window * window_height * 2 * range * weight + weight > 65535) --range;
  return range;
}

// Gradient v -> matching value: |v| through a concave curve of three straight pieces, sign kept:
// sum of slope[i] * min(|v|, knee[i]) / 4096, rounded, at most range. The sum must stay below 65536 - 2048.
struct Curve {
  std::uint16_t knee[3];
  std::uint16_t slope[3];
  int range;
};

// Which gradient a pixel of the left matching image holds, and with which one of the right image it is compared.
enum class Channels { horizontal, checkered };  // checkered: vertical where x + y is odd
constexpr int channel(Channels channels, int x, int y) { return channels == Channels::checkered ? (x + y) & 1 : 0; }

struct PrefilterRow {
  const std::uint8_t* above;
  const std::uint8_t* row;
  const std::uint8_t* below;
  int width;
  Curve curve;
};

// What the matcher finds for each pixel of a row: costs are sums of absolute differences over the window. The rows lie
// a fixed distance apart, so that one address reaches them all.
struct MatchRow {
  static constexpr int kStride = 16384 + 160;
  enum { kDisparity, kBest, kBelow, kAbove, kSecond, kBeyond, kFound, kOther = kFound + 2, kRows = kOther + 2 };
  std::uint16_t* rows;  // kRows * kStride

  // px; kUnknownDisparity where no window fits or the best one ends the range
  std::int16_t* disparity() const { return reinterpret_cast<std::int16_t*>(rows + kDisparity * kStride); }
  // cost at `disparity`; this one and the next are only set where it is known
  std::uint16_t* best() const { return rows + kBest * kStride; }
  std::uint16_t* below() const { return rows + kBelow * kStride; }  // cost at disparity - 1
  std::uint16_t* above() const { return rows + kAbove * kStride; }  // cost at disparity + 1
  // lowest cost more than 1 px away, 65535 / key_weight() if there is none
  std::uint16_t* second() const { return rows + kSecond * kStride; }
  // scratch of the vector kernels: the cost 2 px away on the side that shares no pair with the best one; key and lane
  // of the winner and of the best one outside its pairs
  std::uint16_t* beyond() const { return rows + kBeyond * kStride; }
  std::uint32_t* found() const { return reinterpret_cast<std::uint32_t*>(rows + kFound * kStride); }
  std::uint32_t* other() const { return reinterpret_cast<std::uint32_t*>(rows + kOther * kStride); }
};

struct MatchJob {
  const std::uint8_t* left;      // matching images: pixel (0, 0); values 0 .. 2 * range
  const std::uint8_t* right[2];  // by channel
  std::ptrdiff_t stride;         // of all three
  Channels channels;
  int width;
  int height;
  int window;
  int window_height;
  int min_disparity;
  int num_disparities;
  int y;                  // the row to match; beyond the image its first or last row is repeated
  int step;               // 1: rows are matched downwards, -1: upwards
  bool first;             // whether `columns` must be built anew; otherwise they are those of row y - step
  bool second;            // whether out.second() is needed
  std::uint8_t* columns;  // column sums and scratch, column_cells()
  std::uint16_t* costs;   // cost_cells()
  MatchRow out;
};

// The vector kernels go in blocks of pixels, the last of which reaches beyond the row.
inline constexpr int kMatchBlock = 8;
// Pixels of a row of the left image, four bytes each.
constexpr std::size_t spread_cells(int width) { return static_cast<std::size_t>(width + kMatchBlock + 15) / 16 * 16; }
// Elements of the two scratch buffers; 64-byte aligned.
constexpr std::size_t column_cells(int width, int num_disparities) {
  return static_cast<std::size_t>(width + kMatchBlock + 1) *
             static_cast<std::size_t>(padded_disparities(num_disparities)) +
         2 * sizeof(std::uint32_t) * spread_cells(width);
}
constexpr std::size_t cost_cells(int num_disparities) {
  return 3 * 3 * kMatchBlock / 2 * static_cast<std::size_t>(padded_disparities(num_disparities));
}

// A row to smooth: each known value moves to the mean of itself and of those neighbours that are at most `reach` away.
// result = (value * scale + mean difference * scale + round) >> shift.
struct SmoothRow {
  const std::int16_t* centre;
  const std::int16_t* neighbour[6];  // rows or the row itself shifted; unknown where the image ends
  int neighbours;
  int reach;
  int scale;
  int round;
  int shift;
};
// 32768 / n: means without a division. One value alone has no difference to share out.
inline constexpr std::int32_t kReciprocals[8] = {0, 32767, 16384, 10923, 8192, 6554, 5461, 4681};

// The left-right check of a row: each right pixel's best partner among the left pixels that chose it, of equal costs
// the right-most one; for each left pixel how far from it that of its match is.
struct CrossCheck {
  MatchRow found;
  int width;
  std::uint32_t* partner;  // scratch, 3 * width: cost << 16 | 65535 - column
  std::int16_t* astray;    // px; anything where nothing was found
};

// From costs to a sub-pixel disparity, or unknown where a test fails.
struct FinishRow {
  MatchRow found;
  const std::int16_t* astray;    // see CrossCheck
  const std::uint16_t* texture;  // sum over the window
  int width;
  int uniqueness_percent;    // 0 = off
  int texture_threshold;     // of the sum, 0 = off
  int left_right_tolerance;  // < 0 = off
};

// Which pixels of a disparity row belong together; a bit for each pixel, in words of 64, the last one filled with 0.
struct LinkRow {
  const std::int16_t* row;
  const std::int16_t* above;
  int width;
  int range;              // a step that still links
  std::uint64_t* known;   // not unknown
  std::uint64_t* across;  // linked with the pixel to the left
  std::uint64_t* down;    // linked with the pixel above
};

struct Table {
  // out[i] = bilinear sample of raw, 0 where there is no source.
  void (*remap_row)(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapRow& map, int width, std::uint8_t* out);
  // 3x3 Sobel gradients, 0 in the first and last column; matching = curve(gradient) + range.
  // left: filtered = clip(horizontal, +-cap) + cap; the gradient in `matching` by channel of (x, y).
  void (*prefilter_left)(const PrefilterRow& in, Channels channels, int y, int cap, std::uint8_t* filtered,
                         std::uint8_t* matching);
  void (*prefilter_right)(const PrefilterRow& in, std::uint8_t* horizontal, std::uint8_t* vertical);
  void (*match_row)(const MatchJob& job);
  // columns[x] += |added[x] - neutral| - |removed[x] - neutral|
  void (*texture_columns)(const std::uint8_t* added, const std::uint8_t* removed, int neutral, int width,
                          std::uint16_t* columns);
  // out[x] = sum of columns[x - radius .. x + radius], for x in [radius, width - radius)
  void (*texture_sums)(const std::uint16_t* columns, int width, int radius, std::uint16_t* out);
  void (*cross_check)(const CrossCheck& in);
  void (*finish_row)(const FinishRow& in, std::int16_t* out);
  void (*link_row)(const LinkRow& in);
  void (*smooth_row)(const SmoothRow& in, int width, std::int16_t* out);
};

// All tables of this build.
const KernelTables<Table>& tables();
// The one for active_isa().
const Table& active();

extern const Table kReference;
// What each instruction set overrides, in a file of its own. Nothing from the standard library is called in kernels:
// the linker keeps one copy of an inline function for the whole program, and it may be the one that a lesser machine
// cannot run.
void use_sse4(Table& table);
void use_avx2(Table& table);
void use_avx512(Table& table);
void use_neon(Table& table);
void match_row_avx2(const MatchJob& job);

// The plain kernels by name: vectors leave the end of a row to them.
namespace reference {
void remap_row(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapRow& map, int begin, int end,
               std::uint8_t* out);
void prefilter_left(const PrefilterRow& in, Channels channels, int y, int cap, std::uint8_t* filtered,
                    std::uint8_t* matching);
void prefilter_right(const PrefilterRow& in, std::uint8_t* horizontal, std::uint8_t* vertical);
void cross_check(const CrossCheck& in);
void finish_row(const FinishRow& in, std::int16_t* out);
void texture_columns(const std::uint8_t* added, const std::uint8_t* removed, int neutral, int width,
                     std::uint16_t* columns);
void texture_sums(const std::uint16_t* columns, int width, int radius, std::uint16_t* out);
void link_row(const LinkRow& in);
void smooth_row(const SmoothRow& in, int width, std::int16_t* out);
}  // namespace reference

}  // namespace cliquevo::stereo::kernels
