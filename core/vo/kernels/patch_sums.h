// SPDX-License-Identifier: BSD-3-Clause
// Sampling and the sums of patch alignment, eight pixels at a time; as in motion_sums.h one formula for every
// instruction set, with the same order of every sum.
#pragma once

#include "core/vo/kernels/intrinsics.h"
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
CLIQUEVO_FLOATS_OPERATOR(-)
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
inline VectorFloats operator-(VectorFloats a, VectorFloats b) {
  return {{a.half[0] - b.half[0], a.half[1] - b.half[1]}};
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

// v where `inside` is 1, 0 where it is 0: padding counts for nothing, whatever was read there.
inline PlainFloats only(PlainFloats v, PlainFloats inside) {
  for (int i = 0; i < kPatchLanes; ++i) v.lane[i] = inside.lane[i] > 0.0F ? v.lane[i] : 0.0F;
  return v;
}
#if defined(__AVX2__)
inline VectorFloats only(VectorFloats v, VectorFloats inside) {
  const VectorFloats zero{};
  return zero < inside ? v : zero;
}
#else
inline VectorFloats only(VectorFloats v, VectorFloats inside) {
  const HalfFloats zero{};
  return {{zero < inside.half[0] ? v.half[0] : zero, zero < inside.half[1] ? v.half[1] : zero}};
}
#endif

// ((0 + 4) + (2 + 6)) + ((1 + 5) + (3 + 7))
inline float sum_floats(const PlainFloats& v) {
  const float* lane = v.lane;
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}
inline float sum_floats(const VectorFloats& v) {
  using Four = float __attribute__((vector_size(16)));
  Four half[2];
  __builtin_memcpy(half, &v, sizeof half);
  const Four four = half[0] + half[1];
  const Four two = four + __builtin_shufflevector(four, four, 2, 3, 0, 1);
  return two[0] + two[1];
}

inline void patch_sample_plain(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride,
                               const PatchPlace& place, int first, int last, float mean, float* samples) {
  for (int i = first * grid.side; i < last * grid.side; ++i) {
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
inline V all_floats(float v) {
  float lanes[kPatchLanes];
  for (float& lane : lanes) lane = v;
  return load_floats<V>(lanes);
}

// Eight bytes as they are.
inline void load_bytes(const std::uint8_t* from, PlainFloats& out) {
  for (int i = 0; i < kPatchLanes; ++i) out.lane[i] = static_cast<float>(from[i]);
}
#if defined(__AVX2__)
inline void load_bytes(const std::uint8_t* from, VectorFloats& out) {
  out = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
}
#elif defined(__SSE4_1__)
inline void load_bytes(const std::uint8_t* from, VectorFloats& out) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  out.half[0] = _mm_cvtepi32_ps(_mm_cvtepu8_epi32(bytes));
  out.half[1] = _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_srli_si128(bytes, 4)));
}
#else
inline void load_bytes(const std::uint8_t* from, VectorFloats& out) {
  float lanes[kPatchLanes];
  for (int i = 0; i < kPatchLanes; ++i) lanes[i] = static_cast<float>(from[i]);
  __builtin_memcpy(&out, lanes, sizeof out);
}
#endif

// Samples of a template that lies on whole pixels.
template <class V>
void patch_copy_of(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, float* samples) {
  for (int y = 0; y < grid.side; ++y) {  // whole packs; what is too much is overwritten by the next row
    const std::uint8_t* from = image + y * stride;
    float* to = samples + y * grid.side;
    V packs[2];
    load_bytes(from, packs[0]);
    load_bytes(from + kPatchLanes, packs[1]);
    __builtin_memcpy(to, packs, sizeof packs);
    if (grid.side > 2 * kPatchLanes) to[2 * kPatchLanes] = static_cast<float>(from[2 * kPatchLanes]);
  }
}

// Eight samples `right` of whole pixels.
template <class V>
inline V samples_across(const std::uint8_t* from, V right) {
  V here{};
  V next{};
  load_bytes(from, here);
  load_bytes(from + 1, next);
  return here + right * (next - here);
}

// Samples of a template that lies between pixels.
template <class V>
void patch_shift_of(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, float right, float down,
                    float* samples) {
  const V ax = all_floats<V>(right);
  const V ay = all_floats<V>(down);
  constexpr int kMostPacks = (kMaxPatchSide + kPatchLanes - 1) / kPatchLanes;
  const int packs = (grid.side + kPatchLanes - 1) / kPatchLanes;
  V top[kMostPacks];
  for (int k = 0; k < packs; ++k) top[k] = samples_across(image + k * kPatchLanes, ax);
  for (int y = 0; y < grid.side; ++y) {  // whole packs; what is too much is overwritten by the next row
    for (int k = 0; k < packs; ++k) {
      const V low = samples_across(image + (y + 1) * stride + k * kPatchLanes, ax);
      const V value = top[k] + ay * (low - top[k]);
      __builtin_memcpy(samples + y * grid.side + k * kPatchLanes, &value, sizeof value);
      top[k] = low;
    }
  }
}

template <class V>
void patch_cut_of(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, float right, float down,
                  PatchInner& out) {
  alignas(32) float samples[kMaxPatchSamples];
  if (right == 0.0F && down == 0.0F) {
    patch_copy_of<V>(grid, image, stride, samples);
  } else {
    patch_shift_of<V>(grid, image, stride, right, down, samples);
  }
  const V quarter = all_floats<V>(0.25F);
  const int rows = 2 * grid.radius + 1;
  V sum = all_floats<V>(0.0F);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < grid.row; x += kPatchLanes) {
      sum = sum + only(load_floats<V>(samples + (y + 1) * grid.side + x + 1), load_floats<V>(grid.inside + x));
    }
  }
  out.mean = sum_floats(sum) / static_cast<float>(rows * rows);
  const V mean = all_floats<V>(out.mean);
  V tt = all_floats<V>(0.0F);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < grid.row; x += kPatchLanes) {
      const int at = y * grid.row + x;
      const float* s = samples + (y + 1) * grid.side + x + 1;
      const V inside = load_floats<V>(grid.inside + x);
      const V t = only(load_floats<V>(s) - mean, inside);
      const V gx = only((load_floats<V>(s + 1) - load_floats<V>(s - 1)) * quarter, inside);
      const V gy = only((load_floats<V>(s + grid.side) - load_floats<V>(s - grid.side)) * quarter, inside);
      tt = tt + t * t;
      __builtin_memcpy(out.t + at, &t, sizeof t);
      __builtin_memcpy(out.gx + at, &gx, sizeof gx);
      __builtin_memcpy(out.gy + at, &gy, sizeof gy);
    }
  }
  out.tt = sum_floats(tt);
}

// The sums of PatchSums, a pack of eight at a time.
template <class V, bool kBoth>
struct PatchAdder {
  V w = all_floats<V>(0.0F), ww = w, tw = w, gx = w, gy = w, gxx = w, gxy = w, gyy = w, gxt = w, gyt = w, gxw = w,
    gyw = w;

  // `at`: where in the inner part; `sample`: of the image, its central differences dx and dy.
  [[gnu::always_inline]] void add(const PatchInner& inner, int at, V inside, V sample, V dx, V dy) {
    const V quarter = all_floats<V>(0.25F);
    const V t = load_floats<V>(inner.t + at);
    const V here = only(sample, inside);
    const V across = load_floats<V>(inner.gx + at) + only(dx * quarter, inside);
    w = w + here;
    ww = ww + here * here;
    tw = tw + t * here;
    gx = gx + across;
    gxx = gxx + across * across;
    gxt = gxt + across * t;
    gxw = gxw + across * here;
    if constexpr (kBoth) {
      const V down = load_floats<V>(inner.gy + at) + only(dy * quarter, inside);
      gy = gy + down;
      gxy = gxy + across * down;
      gyy = gyy + down * down;
      gyt = gyt + down * t;
      gyw = gyw + down * here;
    }
  }

  void finish(PatchSums& out) const {
    out = {};
    out.w = sum_floats(w);
    out.ww = sum_floats(ww);
    out.tw = sum_floats(tw);
    out.gx = sum_floats(gx);
    out.gxx = sum_floats(gxx);
    out.gxt = sum_floats(gxt);
    out.gxw = sum_floats(gxw);
    if constexpr (kBoth) {
      out.gy = sum_floats(gy);
      out.gxy = sum_floats(gxy);
      out.gyy = sum_floats(gyy);
      out.gyt = sum_floats(gyt);
      out.gyw = sum_floats(gyw);
    }
  }
};

template <class V, bool kBoth>
void add_samples(const PatchGrid& grid, const PatchInner& inner, const float* samples, PatchSums& out) {
  PatchAdder<V, kBoth> sums;
  for (int y = 0; y < 2 * grid.radius + 1; ++y) {
    for (int x = 0; x < grid.row; x += kPatchLanes) {
      const float* s = samples + (y + 1) * grid.side + x + 1;
      V dy = all_floats<V>(0.0F);
      if constexpr (kBoth) dy = load_floats<V>(s + grid.side) - load_floats<V>(s - grid.side);
      sums.add(inner, y * grid.row + x, load_floats<V>(grid.inside + x), load_floats<V>(s),
               load_floats<V>(s + 1) - load_floats<V>(s - 1), dy);
    }
  }
  sums.finish(out);
}

template <class V, bool kBoth>
void patch_sums_of(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, const PatchPlace& place,
                   const PatchInner& inner, PatchSums& out) {
  constexpr int kRing = kBoth ? 0 : 1;  // rows that gradients along the row do without
  alignas(32) float samples[kMaxPatchSamples];
  patch_sample_plain(grid, image, stride, place, kRing, grid.side - kRing, inner.mean, samples);
  add_samples<V, kBoth>(grid, inner, samples, out);
}

}  // namespace
}  // namespace cliquevo::vo
