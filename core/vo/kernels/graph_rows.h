// SPDX-License-Identifier: BSD-3-Clause
// Step A4's rows of the consistency matrix, eight matches at a time; as in patch_sums.h one formula for every
// instruction set, with the same order of every sum.
#pragma once

#include "core/vo/kernels/intrinsics.h"
#include "core/vo/kernels/kernels.h"
#include "core/vo/kernels/patch_sums.h"

namespace cliquevo::vo {
namespace {

static_assert(kGraphLanes == kPatchLanes);

// What patch_sums.h does without. at_most_bits: bit i is set where not b < a in lane i.
inline PlainFloats operator/(PlainFloats a, PlainFloats b) {
  for (int i = 0; i < kGraphLanes; ++i) a.lane[i] /= b.lane[i];
  return a;
}
inline PlainFloats root_of(PlainFloats v) {
  for (float& lane : v.lane) lane = __builtin_sqrtf(lane);
  return v;
}
inline PlainFloats larger_of(PlainFloats a, PlainFloats b) {  // a where b is no number
  for (int i = 0; i < kGraphLanes; ++i) a.lane[i] = a.lane[i] < b.lane[i] ? b.lane[i] : a.lane[i];
  return a;
}
inline unsigned at_most_bits(PlainFloats a, PlainFloats b) {
  unsigned bits = 0;
  for (int i = 0; i < kGraphLanes; ++i) bits |= b.lane[i] < a.lane[i] ? 0U : 1U << i;
  return bits;
}

#if defined(__AVX2__)
inline VectorFloats root_of(VectorFloats v) { return _mm256_sqrt_ps(v); }
inline VectorFloats larger_of(VectorFloats a, VectorFloats b) { return a < b ? b : a; }
inline unsigned at_most_bits(VectorFloats a, VectorFloats b) {
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(b, a, _CMP_NLT_UQ)));
}
#else
inline VectorFloats operator/(VectorFloats a, VectorFloats b) {
  return {{a.half[0] / b.half[0], a.half[1] / b.half[1]}};
}
inline VectorFloats larger_of(VectorFloats a, VectorFloats b) {
  return {{a.half[0] < b.half[0] ? b.half[0] : a.half[0], a.half[1] < b.half[1] ? b.half[1] : a.half[1]}};
}
#if defined(__x86_64__)
inline HalfFloats half_root(HalfFloats v) { return _mm_sqrt_ps(v); }
inline unsigned half_bits(HalfFloats a, HalfFloats b) {
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpnlt_ps(b, a)));
}
#elif defined(__aarch64__)
inline HalfFloats half_root(HalfFloats v) { return vsqrtq_f32(v); }
inline unsigned half_bits(HalfFloats a, HalfFloats b) {
  const uint32x4_t places = {1, 2, 4, 8};
  return vaddvq_u32(vbicq_u32(places, vcltq_f32(b, a)));
}
#else
inline HalfFloats half_root(HalfFloats v) {
  for (int i = 0; i < 4; ++i) v[i] = __builtin_sqrtf(v[i]);
  return v;
}
inline unsigned half_bits(HalfFloats a, HalfFloats b) {
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= b[i] < a[i] ? 0U : 1U << i;
  return bits;
}
#endif
inline VectorFloats root_of(VectorFloats v) { return {{half_root(v.half[0]), half_root(v.half[1])}}; }
inline unsigned at_most_bits(VectorFloats a, VectorFloats b) {
  return half_bits(a.half[0], b.half[0]) | half_bits(a.half[1], b.half[1]) << 4;
}
#endif

template <class V>
void graph_row_of(const GraphNodes& nodes, int node, const GraphTest& test, std::uint8_t* bits) {
  V mine[kGraphFields];
  for (int f = 0; f < kGraphFields; ++f) mine[f] = all_floats<V>(nodes.field[f][node]);
  const V least2 = all_floats<V>(test.least2);
  const V sigmas2 = all_floats<V>(test.sigmas2);
  for (int j = 0; j < nodes.count; j += kGraphLanes) {
    const auto other = [&](int f) { return load_floats<V>(nodes.field[f] + j); };
    const V ax = mine[kAx] - other(kAx), ay = mine[kAy] - other(kAy), az = mine[kAz] - other(kAz);
    const V bx = mine[kBx] - other(kBx), by = mine[kBy] - other(kBy), bz = mine[kBz] - other(kBz);
    const V a2 = ax * ax + ay * ay + az * az;
    const V b2 = bx * bx + by * by + bz * bz;
    const auto along = [](V x, V y, V z, V rx, V ry, V rz) {
      const V sum = x * rx + y * ry + z * rz;
      return sum * sum;
    };
    // First-order variance of both lengths from the range errors along the rays and the position errors across. Where
    // both points are one it is no number, and only the least difference counts.
    const V in_a = along(ax, ay, az, mine[kRangeAx], mine[kRangeAy], mine[kRangeAz]) +
                   along(ax, ay, az, other(kRangeAx), other(kRangeAy), other(kRangeAz));
    const V in_b = along(bx, by, bz, mine[kRangeBx], mine[kRangeBy], mine[kRangeBz]) +
                   along(bx, by, bz, other(kRangeBx), other(kRangeBy), other(kRangeBz));
    const V variance = in_a / a2 + in_b / b2 + (mine[kLateral] + other(kLateral));
    const V difference = root_of(a2) - root_of(b2);
    const V allowed = larger_of(least2, sigmas2 * variance);
    bits[j / kGraphLanes] = static_cast<std::uint8_t>(at_most_bits(difference * difference, allowed));
  }
  if (nodes.count % kGraphLanes != 0) {
    bits[nodes.count / kGraphLanes] &= static_cast<std::uint8_t>((1U << (nodes.count % kGraphLanes)) - 1U);
  }
}

}  // namespace
}  // namespace cliquevo::vo
