// SPDX-License-Identifier: BSD-3-Clause
// The plain statement of every kernel: what the others must equal, and what runs where nothing better is known.
#include <algorithm>
#include <cstdlib>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace reference {

void remap_row(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapRow& map, int begin, int end,
               std::uint8_t* out) {
  for (int i = begin; i < end; ++i) {
    if (map.x[i] < 0) {
      out[i] = 0;
      continue;
    }
    const std::uint8_t* p = raw + map.y[i] * stride + map.x[i];
    const std::uint8_t* q = p + stride;
    const int w = map.weight_x[i];
    const int top = p[0] * (64 - w) + p[1] * w;
    const int bottom = q[0] * (64 - w) + q[1] * w;
    const int value = top + (((bottom - top) * map.weight_y[i] + 32) >> 6);
    out[i] = static_cast<std::uint8_t>((value + 32) >> 6);
  }
}

namespace {

int horizontal_gradient(const PrefilterRow& in, int x) {
  if (x == 0 || x + 1 == in.width) return 0;
  return in.above[x + 1] - in.above[x - 1] + 2 * (in.row[x + 1] - in.row[x - 1]) + in.below[x + 1] - in.below[x - 1];
}

int vertical_gradient(const PrefilterRow& in, int x) {
  if (x == 0 || x + 1 == in.width) return 0;
  return in.below[x - 1] - in.above[x - 1] + 2 * (in.below[x] - in.above[x]) + in.below[x + 1] - in.above[x + 1];
}

std::uint8_t matching_value(const Curve& curve, int gradient) {
  const int size = std::abs(gradient);
  int sum = 2048;
  for (int i = 0; i < 3; ++i) sum += curve.slope[i] * std::min<int>(size, curve.knee[i]);
  const int value = std::min(sum >> 12, curve.range);
  return static_cast<std::uint8_t>(gradient < 0 ? curve.range - value : curve.range + value);
}

}  // namespace

void prefilter_left(const PrefilterRow& in, Channels channels, int y, int cap, std::uint8_t* filtered,
                    std::uint8_t* matching) {
  for (int x = 0; x < in.width; ++x) {
    const int horizontal = horizontal_gradient(in, x);
    filtered[x] = static_cast<std::uint8_t>(std::clamp(horizontal, -cap, cap) + cap);
    matching[x] = matching_value(in.curve, channel(channels, x, y) == 0 ? horizontal : vertical_gradient(in, x));
  }
}

void prefilter_right(const PrefilterRow& in, std::uint8_t* horizontal, std::uint8_t* vertical) {
  for (int x = 0; x < in.width; ++x) {
    horizontal[x] = matching_value(in.curve, horizontal_gradient(in, x));
    vertical[x] = matching_value(in.curve, vertical_gradient(in, x));
  }
}

namespace {

int difference(const MatchJob& job, int x, int y, int d) {
  const int row = std::clamp(y, 0, job.height - 1);
  const std::uint8_t* right = job.right[channel(job.channels, x, row)];
  return std::abs(job.left[row * job.stride + x] - right[row * job.stride + x - d]);
}

void match_row(const MatchJob& job) {
  const int r = job.window / 2;
  const int rows = job.window_height / 2;
  const int n = job.num_disparities;
  const int last = job.min_disparity + n - 1;
  // Column sums, [x][d]: built from all rows of the window, or moved on by one row.
  for (int x = 0; x < job.width; ++x) {
    for (int i = 0; i < n; ++i) {
      const int d = job.min_disparity + i;
      std::uint8_t& sum = job.columns[x * n + i];
      if (job.first) {
        sum = 0;
        for (int j = -rows; j <= rows; ++j) sum = static_cast<std::uint8_t>(sum + difference(job, x, job.y + j, d));
      } else {
        sum = static_cast<std::uint8_t>(sum + difference(job, x, job.y + job.step * rows, d) -
                                        difference(job, x, job.y - job.step * (rows + 1), d));
      }
    }
  }
  std::uint16_t* cost = job.costs;  // of the current pixel, [d]
  for (int x = 0; x < job.width; ++x) {
    job.out.disparity()[x] = kUnknownDisparity;
    if (x < r || x >= job.width - r) continue;
    for (int i = 0; i < n; ++i) {
      int total = 0;
      for (int k = -r; k <= r; ++k) total += job.columns[(x + k) * n + i];
      cost[i] = static_cast<std::uint16_t>(total);
    }
    // Both windows lie within their images.
    const int low = std::max(job.min_disparity, x + r - job.width + 1);
    const int high = std::min(last, x - r);
    if (high - low < 2) continue;
    // Equal costs: counted down from `last`, the first group of 16; in it an even place before an odd one; the first.
    const auto rank = [last](int d) {
      const int e = last - d;
      return (e >> 4) * 16 + (e & 1) * 8 + ((e >> 1) & 7);
    };
    int best = high;
    for (int d = high; d >= low; --d) {
      const int a = cost[d - job.min_disparity];
      const int b = cost[best - job.min_disparity];
      if (a < b || (a == b && rank(d) < rank(best))) best = d;
    }
    if (best == low || best == high) continue;  // an end of the range is no minimum
    const std::uint16_t* c = cost + (best - job.min_disparity);
    std::uint16_t second = static_cast<std::uint16_t>(65535 / key_weight(n));
    for (int d = low; d <= high; ++d) {
      if (std::abs(d - best) > 1) second = std::min(second, cost[d - job.min_disparity]);
    }
    job.out.disparity()[x] = static_cast<std::int16_t>(best);
    job.out.best()[x] = c[0];
    job.out.below()[x] = c[-1];
    job.out.above()[x] = c[1];
    job.out.second()[x] = second;
  }
}

}  // namespace

void cross_check(const CrossCheck& in) {
  const std::int16_t* disparity = in.found.disparity();
  const std::uint16_t* best = in.found.best();
  std::fill(in.partner, in.partner + in.width, UINT32_MAX);
  for (int x = 0; x < in.width; ++x) {
    if (disparity[x] == kUnknownDisparity) continue;
    std::uint32_t& partner = in.partner[x - disparity[x]];
    partner = std::min(partner, static_cast<std::uint32_t>(best[x]) << 16 | static_cast<std::uint32_t>(0xFFFF - x));
  }
  for (int x = 0; x < in.width; ++x) {
    if (disparity[x] == kUnknownDisparity) continue;
    in.astray[x] = static_cast<std::int16_t>(0xFFFF - x - static_cast<int>(in.partner[x - disparity[x]] & 0xFFFF));
  }
}

namespace {

// Round to nearest, ties to even, as every vector unit does it: no libm, the same bits everywhere.
int round_to_int(float v) {
  constexpr float kMagic = 12582912.0F;  // 1.5 * 2^23
  return static_cast<int>((v + kMagic) - kMagic);
}

}  // namespace

void finish_row(const FinishRow& in, std::int16_t* out) {
  for (int x = 0; x < in.width; ++x) {
    out[x] = kUnknownDisparity;
    const int d = in.found.disparity()[x];
    if (d == kUnknownDisparity) continue;
    const int best = in.found.best()[x];
    const int below = in.found.below()[x];
    const int above = in.found.above()[x];
    if (in.texture_threshold > 0 && in.texture[x] < in.texture_threshold) continue;
    if (in.uniqueness_percent > 0 && in.found.second()[x] * 100 <= best * (100 + in.uniqueness_percent)) continue;
    if (in.left_right_tolerance >= 0 && std::abs(in.astray[x]) > in.left_right_tolerance) continue;
    // Two straight flanks of equal slope through the three costs: what a sum of absolute differences looks like.
    const int slope = std::max(below, above) - best;
    const int shift =
        slope == 0 ? 0 : round_to_int(static_cast<float>(8 * (below - above)) / static_cast<float>(slope));
    out[x] = static_cast<std::int16_t>(d * kDisparityScale + shift);
  }
}

void texture_columns(const std::uint8_t* added, const std::uint8_t* removed, int neutral, int width,
                     std::uint16_t* columns) {
  for (int x = 0; x < width; ++x) {
    columns[x] = static_cast<std::uint16_t>(columns[x] + std::abs(added[x] - neutral) - std::abs(removed[x] - neutral));
  }
}

void texture_sums(const std::uint16_t* columns, int width, int radius, std::uint16_t* out) {
  for (int x = radius; x < width - radius; ++x) {
    int sum = 0;
    for (int k = -radius; k <= radius; ++k) sum += columns[x + k];
    out[x] = static_cast<std::uint16_t>(sum);
  }
}

void link_row(const LinkRow& in) {
  for (int word = 0; word * 64 < in.width; ++word) in.known[word] = in.across[word] = in.down[word] = 0;
  for (int x = 0; x < in.width; ++x) {
    const int v = in.row[x];
    if (v == kUnknownDisparity) continue;
    const auto linked = [v, &in](int other) { return other != kUnknownDisparity && std::abs(v - other) <= in.range; };
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    in.known[x / 64] |= bit;
    if (x > 0 && linked(in.row[x - 1])) in.across[x / 64] |= bit;
    if (linked(in.above[x])) in.down[x / 64] |= bit;
  }
}

void smooth_row(const SmoothRow& in, int width, std::int16_t* out) {
  for (int x = 0; x < width; ++x) {
    const int z = in.centre[x];
    int sum = 0;
    int count = 1;
    for (int i = 0; i < in.neighbours; ++i) {
      const int other = in.neighbour[i][x];
      if (other == kUnknownDisparity || std::abs(other - z) > in.reach) continue;
      sum += other - z;
      ++count;
    }
    const int mean = (sum * in.scale * kReciprocals[count] + (1 << 14)) >> 15;
    const int value = z * in.scale + mean;
    out[x] = z == kUnknownDisparity ? kUnknownDisparity : static_cast<std::int16_t>((value + in.round) >> in.shift);
  }
}

}  // namespace reference

namespace {

void remap_whole_row(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapRow& map, int width,
                     std::uint8_t* out) {
  reference::remap_row(raw, stride, map, 0, width, out);
}

}  // namespace

constinit const Table kReference{
    .remap_row = remap_whole_row,
    .prefilter_left = reference::prefilter_left,
    .prefilter_right = reference::prefilter_right,
    .match_row = reference::match_row,
    .texture_columns = reference::texture_columns,
    .texture_sums = reference::texture_sums,
    .cross_check = reference::cross_check,
    .finish_row = reference::finish_row,
    .link_row = reference::link_row,
    .smooth_row = reference::smooth_row,
};

}  // namespace cliquevo::stereo::kernels
