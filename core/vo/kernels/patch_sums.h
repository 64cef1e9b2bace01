// SPDX-License-Identifier: BSD-3-Clause
// Sampling and the sums of patch alignment, eight pixels at a time; as in motion_sums.h one formula for every
// instruction set, with the same order of every sum.
#pragma once

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {
namespace {

struct PlainFloats {
  float lane[kPatchLanes];
};

#define CLIQUEVO_FLOATS_OPERATOR(op)                                          \
  inline PlainFloats operator op(PlainFloats a, PlainFloats b) {              \
    for (int i = 0; i < kPatchLanes; ++i) a.lane[i] = a.lane[i] op b.lane[i]; \
    return a;                                                                 \
  }
CLIQUEVO_FLOATS_OPERATOR(+)
CLIQUEVO_FLOATS_OPERATOR(*)
#undef CLIQUEVO_FLOATS_OPERATOR

#if defined(__AVX2__)
using VectorFloats = float __attribute__((vector_size(32)));
#else
using HalfFloats = float __attribute__((vector_size(16)));
struct VectorFloats {
  HalfFloats half[2];
};
inline VectorFloats operator+(VectorFloats a, VectorFloats b) {
  return {{a.half[0] + b.half[0], a.half[1] + b.half[1]}};
}
inline VectorFloats operator*(VectorFloats a, VectorFloats b) {
  return {{a.half[0] * b.half[0], a.half[1] * b.half[1]}};
}
#endif

template <class V>
inline V load_floats(const float* from) {
  V out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}

template <class V>
inline float sum_floats(V v) {
  float lane[kPatchLanes];
  __builtin_memcpy(lane, &v, sizeof lane);
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

inline void patch_sample_plain(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride,
                               const PatchPlace& place, float mean, float* samples) {
  const int n = grid.side * grid.side;
  for (int i = 0; i < n; ++i) {
    const float fx = place.x + place.xx * grid.dx[i] + place.xy * grid.dy[i];
    const float fy = place.y + place.yx * grid.dx[i] + place.yy * grid.dy[i];
    const int ix = static_cast<int>(fx);
    const int iy = static_cast<int>(fy);
    const float ax = fx - static_cast<float>(ix);
    const float ay = fy - static_cast<float>(iy);
    const std::uint8_t* p = image + iy * stride + ix;
    const std::uint8_t* q = p + stride;
    const float top = static_cast<float>(p[0]) + ax * static_cast<float>(p[1] - p[0]);
    const float low = static_cast<float>(q[0]) + ax * static_cast<float>(q[1] - q[0]);
    samples[i] = top + ay * (low - top) - mean;
  }
}

template <class V>
void patch_sums_of(const PatchGrid& grid, const PatchInner& inner, const float* samples, PatchSums& out) {
  V sums[12];
  __builtin_memset(sums, 0, sizeof sums);
  float quarters[kPatchLanes];
  float minus[kPatchLanes];
  for (int i = 0; i < kPatchLanes; ++i) quarters[i] = 0.25F, minus[i] = -1.0F;
  const V quarter = load_floats<V>(quarters);
  const V negative = load_floats<V>(minus);
  const int rows = 2 * grid.radius + 1;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < grid.row; x += kPatchLanes) {
      const int at = y * grid.row + x;
      const float* s = samples + (y + 1) * grid.side + x + 1;
      const V mask = load_floats<V>(grid.inside + x);
      const V t = load_floats<V>(inner.t + at);
      const V w = load_floats<V>(s) * mask;
      const V dx = load_floats<V>(s + 1) + load_floats<V>(s - 1) * negative;
      const V dy = load_floats<V>(s + grid.side) + load_floats<V>(s - grid.side) * negative;
      const V gx = load_floats<V>(inner.gx + at) + dx * quarter * mask;
      const V gy = load_floats<V>(inner.gy + at) + dy * quarter * mask;
      sums[0] = sums[0] + w;
      sums[1] = sums[1] + w * w;
      sums[2] = sums[2] + t * w;
      sums[3] = sums[3] + gx;
      sums[4] = sums[4] + gy;
      sums[5] = sums[5] + gx * gx;
      sums[6] = sums[6] + gx * gy;
      sums[7] = sums[7] + gy * gy;
      sums[8] = sums[8] + gx * t;
      sums[9] = sums[9] + gy * t;
      sums[10] = sums[10] + gx * w;
      sums[11] = sums[11] + gy * w;
    }
  }
  out = {sum_floats(sums[0]), sum_floats(sums[1]), sum_floats(sums[2]),  sum_floats(sums[3]),
         sum_floats(sums[4]), sum_floats(sums[5]), sum_floats(sums[6]),  sum_floats(sums[7]),
         sum_floats(sums[8]), sum_floats(sums[9]), sum_floats(sums[10]), sum_floats(sums[11])};
}

}  // namespace
}  // namespace cliquevo::vo
