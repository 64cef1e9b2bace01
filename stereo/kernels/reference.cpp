// SPDX-License-Identifier: BSD-3-Clause
// The plain statement of every kernel: what the others must equal, and what runs where nothing better is known.
#include <algorithm>
#include <cstdlib>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

void remap_row(const std::uint8_t* raw, std::ptrdiff_t stride, const RemapPixel* map, int width, std::uint8_t* out) {
  for (int i = 0; i < width; ++i) {
    const RemapPixel& m = map[i];
    if (m.x < 0) {
      out[i] = 0;
      continue;
    }
    const std::uint8_t* p = raw + m.y * stride + m.x;
    const std::uint8_t* q = p + stride;
    const int w = m.weight_x;
    const int top = p[0] * (64 - w) + p[1] * w;
    const int bottom = q[0] * (64 - w) + q[1] * w;
    const int value = top + (((bottom - top) * m.weight_y + 32) >> 6);
    out[i] = static_cast<std::uint8_t>((value + 32) >> 6);
  }
}

void prefilter_row(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int width, int cap,
                   int scale, int range, std::uint8_t* filtered, std::uint8_t* matching) {
  for (int x = 0; x < width; ++x) {
    int v = 0;
    if (x > 0 && x + 1 < width) {
      v = above[x + 1] - above[x - 1] + 2 * (row[x + 1] - row[x - 1]) + below[x + 1] - below[x - 1];
      v = std::clamp(v, -cap, cap);
    }
    filtered[x] = static_cast<std::uint8_t>(v + cap);
    matching[x] = static_cast<std::uint8_t>(((v * scale + (1 << 14)) >> 15) + range);
  }
}

int difference(const MatchJob& job, int x, int y, int d) {
  const int row = std::clamp(y, 0, job.height - 1);
  return std::abs(job.left[row * job.stride + x] - job.right[row * job.stride + x - d]);
}

void match_row(const MatchJob& job) {
  const int r = job.window / 2;
  const int n = job.num_disparities;
  const int last = job.min_disparity + n - 1;
  // Column sums, [x][d]: built from the whole window, or moved down by one row.
  for (int x = 0; x < job.width; ++x) {
    for (int i = 0; i < n; ++i) {
      const int d = job.min_disparity + i;
      std::uint8_t& sum = job.columns[x * n + i];
      if (job.first) {
        int total = 0;
        for (int j = -r; j <= r; ++j) total += difference(job, x, job.y + j, d);
        sum = static_cast<std::uint8_t>(total);
      } else {
        sum = static_cast<std::uint8_t>(sum + difference(job, x, job.y + r, d) - difference(job, x, job.y - r - 1, d));
      }
    }
  }
  std::uint16_t* cost = job.costs;  // of the current pixel, [d]
  for (int x = 0; x < job.width; ++x) {
    job.out.disparity[x] = kUnknownDisparity;
    if (x < r || x >= job.width - r) continue;
    for (int i = 0; i < n; ++i) {
      int total = 0;
      for (int k = -r; k <= r; ++k) total += job.columns[(x + k) * n + i];
      cost[i] = static_cast<std::uint16_t>(total);
    }
    // Both windows lie within their images.
    const int low = std::max(job.min_disparity, x + r - job.width + 1);
    const int high = std::min(last, x - r);
    int best = high;
    for (int d = high; d >= low; --d) {  // of equal costs the nearer one
      if (cost[d - job.min_disparity] < cost[best - job.min_disparity]) best = d;
    }
    if (best <= low || best >= high) continue;  // an end of the range is no minimum
    const std::uint16_t* c = cost + (best - job.min_disparity);
    std::uint16_t second = 65535;
    for (int d = low; d <= high; ++d) {
      if (std::abs(d - best) > 1) second = std::min(second, cost[d - job.min_disparity]);
    }
    job.out.disparity[x] = static_cast<std::int16_t>(best);
    job.out.best[x] = c[0];
    job.out.below[x] = c[-1];
    job.out.above[x] = c[1];
    job.out.second[x] = second;
  }
}

}  // namespace

const Table kReference{Isa::reference, remap_row, prefilter_row, match_row};

}  // namespace cliquevo::stereo::kernels
