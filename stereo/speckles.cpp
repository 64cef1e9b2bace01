// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/speckles.h"

#include <algorithm>
#include <cstdlib>

namespace cliquevo::stereo {

void SpeckleFilter::prepare(int width, int height) {
  runs_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

std::int32_t SpeckleFilter::root(std::int32_t i) {
  while (runs_[i].parent != i) {
    runs_[i].parent = runs_[runs_[i].parent].parent;
    i = runs_[i].parent;
  }
  return i;
}

void SpeckleFilter::join(std::int32_t a, std::int32_t b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  runs_[b].parent = a;
  runs_[a].pixels += runs_[b].pixels;
}

void SpeckleFilter::remove(ImageView<std::int16_t> disparity, int size, int range) {
  const auto linked = [range](int a, int b) { return std::abs(a - b) <= range; };
  std::int32_t count = 0;
  std::int32_t above_begin = 0;  // runs of the row above: [above_begin, row_begin)
  for (int y = 0; y < disparity.height; ++y) {
    const std::int16_t* row = disparity.row(y);
    const std::int32_t row_begin = count;
    for (int x = 0; x < disparity.width;) {
      if (row[x] == kUnknownDisparity) {
        ++x;
        continue;
      }
      const int begin = x++;
      while (x < disparity.width && row[x] != kUnknownDisparity && linked(row[x], row[x - 1])) ++x;
      runs_[count] = {begin, x, y, count, x - begin};
      ++count;
    }
    if (y > 0) {
      const std::int16_t* above = disparity.row(y - 1);
      std::int32_t a = above_begin;
      for (std::int32_t b = row_begin; b < count; ++b) {
        while (a < row_begin && runs_[a].end <= runs_[b].begin) ++a;
        for (std::int32_t k = a; k < row_begin && runs_[k].begin < runs_[b].end; ++k) {
          const int end = std::min(runs_[k].end, runs_[b].end);
          for (int x = std::max(runs_[k].begin, runs_[b].begin); x < end; ++x) {
            if (linked(row[x], above[x])) {
              join(k, b);
              break;
            }
          }
        }
      }
    }
    above_begin = row_begin;
  }
  for (std::int32_t i = 0; i < count; ++i) {
    if (runs_[root(i)].pixels >= size) continue;
    std::int16_t* row = disparity.row(runs_[i].y);
    std::fill(row + runs_[i].begin, row + runs_[i].end, kUnknownDisparity);
  }
}

}  // namespace cliquevo::stereo
