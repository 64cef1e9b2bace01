// SPDX-License-Identifier: BSD-3-Clause
// What every instruction set's FAST shares: the circle, and the score of a pixel that passed the test.
// Internal linkage on purpose: each kernel file is compiled with other machine options.
#pragma once

#include <cstddef>
#include <cstdint>

namespace cliquevo::vo {
namespace {

// The 16 pixels at radius 3, clockwise from the top.
constexpr int kCircleX[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
constexpr int kCircleY[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};

inline int smaller(int a, int b) { return a < b ? a : b; }
inline int larger(int a, int b) { return a > b ? a : b; }

// The largest t for which 9 contiguous pixels all differ from the centre by more than t to one side; -1: none.
inline int fast_score(const std::uint8_t* p, const std::ptrdiff_t (&offsets)[16]) {
  int d[25];
  for (int i = 0; i < 16; ++i) d[i] = p[offsets[i]] - p[0];
  for (int i = 16; i < 25; ++i) d[i] = d[i - 16];
  int best = 0;
  for (int i = 0; i < 16; ++i) {
    int low = d[i];
    int high = d[i];
    for (int k = 1; k < 9; ++k) {
      low = smaller(low, d[i + k]);
      high = larger(high, d[i + k]);
    }
    best = larger(best, larger(low, -high));
  }
  return best - 1;
}

inline void circle_offsets(std::ptrdiff_t stride, std::ptrdiff_t (&offsets)[16]) {
  for (int i = 0; i < 16; ++i) offsets[i] = kCircleY[i] * stride + kCircleX[i];
}

}  // namespace
}  // namespace cliquevo::vo
