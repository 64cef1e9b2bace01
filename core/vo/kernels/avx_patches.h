// SPDX-License-Identifier: BSD-3-Clause
// Patch alignment with registers of eight floats, for AVX2 and AVX-512 (which has twice as many such registers).
// Internal linkage on purpose: each kernel file is compiled with other machine options.
#pragma once

#include <immintrin.h>

#include "core/vo/kernels/patch_sums.h"

namespace cliquevo::vo {
namespace {

// Bilinear samples of an image about a place, less a mean.
class Sampler {
 public:
  Sampler(const std::uint8_t* image, std::ptrdiff_t stride, const PatchPlace& place, float mean)
      : image_(image),
        stride_(stride),
        x_(_mm256_set1_ps(place.x)),
        y_(_mm256_set1_ps(place.y)),
        xx_(_mm256_set1_ps(place.xx)),
        xy_(_mm256_set1_ps(place.xy)),
        yx_(_mm256_set1_ps(place.yx)),
        yy_(_mm256_set1_ps(place.yy)),
        step_(_mm256_set1_epi32(static_cast<int>(stride))),
        mean_(_mm256_set1_ps(mean)) {}

  [[gnu::always_inline]] __m256 at(__m256 dx, __m256 dy) const {
    const __m256i byte = _mm256_set1_epi32(255);
    const __m256 fx = _mm256_add_ps(_mm256_add_ps(x_, _mm256_mul_ps(xx_, dx)), _mm256_mul_ps(xy_, dy));
    const __m256 fy = _mm256_add_ps(_mm256_add_ps(y_, _mm256_mul_ps(yx_, dx)), _mm256_mul_ps(yy_, dy));
    const __m256i ix = _mm256_cvttps_epi32(fx), iy = _mm256_cvttps_epi32(fy);
    const __m256 ax = _mm256_sub_ps(fx, _mm256_cvtepi32_ps(ix)), ay = _mm256_sub_ps(fy, _mm256_cvtepi32_ps(iy));
    // Each gather brings four neighbours of a row, of which the first two count.
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(iy, step_), ix);
    const __m256i p = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image_), at, 1);
    const __m256i q = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image_ + stride_), at, 1);
    const __m256i p0 = _mm256_and_si256(p, byte), p1 = _mm256_and_si256(_mm256_srli_epi32(p, 8), byte);
    const __m256i q0 = _mm256_and_si256(q, byte), q1 = _mm256_and_si256(_mm256_srli_epi32(q, 8), byte);
    const __m256 top =
        _mm256_add_ps(_mm256_cvtepi32_ps(p0), _mm256_mul_ps(ax, _mm256_cvtepi32_ps(_mm256_sub_epi32(p1, p0))));
    const __m256 low =
        _mm256_add_ps(_mm256_cvtepi32_ps(q0), _mm256_mul_ps(ax, _mm256_cvtepi32_ps(_mm256_sub_epi32(q1, q0))));
    return _mm256_sub_ps(_mm256_add_ps(top, _mm256_mul_ps(ay, _mm256_sub_ps(low, top))), mean_);
  }

 private:
  const std::uint8_t* image_;
  std::ptrdiff_t stride_;
  __m256 x_, y_, xx_, xy_, yx_, yy_;
  __m256i step_;
  __m256 mean_;
};

// Of the usual radius a row of the inner part is one pack: then nothing is written only to be read again at another
// place, for which the processor would have to wait.
constexpr int kUsualRadius = 3;
constexpr int kUsualRows = 2 * kUsualRadius + 1;
constexpr int kUsualSide = kUsualRows + 2;

// Lanes moved towards the first; those behind the last come from the front again.
template <int kBy>
inline __m256 turned(__m256 v) {
  return _mm256_permutevar8x32_ps(v, _mm256_setr_epi32(kBy, (kBy + 1) % 8, (kBy + 2) % 8, (kBy + 3) % 8, (kBy + 4) % 8,
                                                       (kBy + 5) % 8, (kBy + 6) % 8, (kBy + 7) % 8));
}

template <bool kBoth>
void patch_sums(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, const PatchPlace& place,
                const PatchInner& inner, PatchSums& out) {
  constexpr int kRing = kBoth ? 0 : 1;  // rows that gradients along the row do without
  const Sampler sampler(image, stride, place, inner.mean);
  if (grid.radius != kUsualRadius) {
    alignas(32) float samples[kMaxPatchSamples];
    for (int i = kRing * grid.side; i < (grid.side - kRing) * grid.side; i += kPatchLanes) {
      _mm256_storeu_ps(samples + i, sampler.at(_mm256_loadu_ps(grid.dx + i), _mm256_loadu_ps(grid.dy + i)));
    }
    return add_samples<VectorFloats, kBoth>(grid, inner, samples, out);
  }
  __m256 rows[kUsualSide];  // their first eight samples
  for (int y = kRing; y < kUsualSide - kRing; ++y) {
    const int i = y * kUsualSide;
    rows[y] = sampler.at(_mm256_loadu_ps(grid.dx + i), _mm256_loadu_ps(grid.dy + i));
  }
  // The ninth, of the inner rows.
  const __m256 last =
      sampler.at(_mm256_set1_ps(kUsualRadius + 1), _mm256_setr_ps(-3.0F, -2.0F, -1.0F, 0.0F, 1.0F, 2.0F, 3.0F, 3.0F));
  const __m256 inside = _mm256_load_ps(grid.inside);
  PatchAdder<VectorFloats, kBoth> sums;
  for (int y = 0; y < kUsualRows; ++y) {
    const __m256 row = rows[y + 1];
    const __m256 ninth = _mm256_permutevar8x32_ps(last, _mm256_set1_epi32(y));
    const __m256 dx = _mm256_sub_ps(_mm256_blend_ps(turned<2>(row), ninth, 0x40), row);
    __m256 dy = _mm256_setzero_ps();
    if constexpr (kBoth) dy = _mm256_sub_ps(turned<1>(rows[y + 2]), turned<1>(rows[y]));
    sums.add(inner, y * kPatchLanes, inside, turned<1>(row), dx, dy);
  }
  sums.finish(out);
}

void patch_cut(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, float right, float down,
               PatchInner& out) {
  if (grid.radius != kUsualRadius) return patch_cut_of<VectorFloats>(grid, image, stride, right, down, out);
  VectorFloats middle[kUsualSide], across[kUsualSide];  // samples from the second on, and central differences
  if (right == 0.0F && down == 0.0F) {
    for (int y = 0; y < kUsualSide; ++y, image += stride) {
      VectorFloats first{}, third{};
      load_bytes(image, first);
      load_bytes(image + 1, middle[y]);
      load_bytes(image + 2, third);
      across[y] = third - first;
    }
  } else {
    const VectorFloats ax = all_floats<VectorFloats>(right), ay = all_floats<VectorFloats>(down);
    VectorFloats top[2] = {samples_across(image, ax), samples_across(image + 1, ax)};
    for (int y = 0; y < kUsualSide; ++y) {
      image += stride;
      const VectorFloats low[2] = {samples_across(image, ax), samples_across(image + 1, ax)};
      middle[y] = top[1] + ay * (low[1] - top[1]);
      across[y] = turned<1>(middle[y]) - (top[0] + ay * (low[0] - top[0]));
      top[0] = low[0], top[1] = low[1];
    }
  }
  const VectorFloats inside = load_floats<VectorFloats>(grid.inside);
  const VectorFloats quarter = all_floats<VectorFloats>(0.25F);
  VectorFloats sum = all_floats<VectorFloats>(0.0F);
  for (int y = 1; y <= kUsualRows; ++y) sum = sum + only(middle[y], inside);
  out.mean = sum_floats(sum) / static_cast<float>(kUsualRows * kUsualRows);
  const VectorFloats mean = all_floats<VectorFloats>(out.mean);
  VectorFloats tt = all_floats<VectorFloats>(0.0F);
  for (int y = 1; y <= kUsualRows; ++y) {
    const int at = (y - 1) * kPatchLanes;
    const VectorFloats t = only(middle[y] - mean, inside);
    tt = tt + t * t;
    _mm256_store_ps(out.t + at, t);
    _mm256_store_ps(out.gx + at, only(across[y] * quarter, inside));
    _mm256_store_ps(out.gy + at, only((middle[y + 1] - middle[y - 1]) * quarter, inside));
  }
  out.tt = sum_floats(tt);
}

}  // namespace
}  // namespace cliquevo::vo
