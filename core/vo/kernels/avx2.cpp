// SPDX-License-Identifier: BSD-3-Clause
#include <immintrin.h>

#include "core/vo/kernels/fast_circle.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"
#include "core/vo/kernels/tables.h"

namespace cliquevo::vo {
namespace {

__m256i load(const std::uint8_t* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }

int fast_row(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::int16_t* columns,
             std::uint8_t* scores) {
  std::ptrdiff_t offsets[16];
  circle_offsets(stride, offsets);
  const __m256i t = _mm256_set1_epi8(static_cast<char>(threshold));
  const __m256i zero = _mm256_setzero_si256();
  int n = 0;
  if (x1 - x0 < 32) return kReferenceKernels.fast_row(row, stride, x0, x1, threshold, columns, scores);
  for (int next = x0; next < x1; next += 32) {
    const int x = next + 32 <= x1 ? next : x1 - 32;  // the last pack overlaps the one before
    const std::uint8_t* p = row + x;
    const __m256i c = load(p);
    const __m256i above = _mm256_adds_epu8(c, t);
    const __m256i below = _mm256_subs_epu8(c, t);
    // "not brighter" and "not darker" of a circle pixel, as 0 / nonzero bytes
    const auto excess = [&](int i) { return _mm256_subs_epu8(load(p + offsets[i]), above); };
    const auto deficit = [&](int i) { return _mm256_subs_epu8(below, load(p + offsets[i])); };
    // Nine contiguous pixels hold at least one of each opposite pair: reject by the four on the axes first.
    const __m256i b = _mm256_and_si256(_mm256_cmpeq_epi8(_mm256_or_si256(excess(0), excess(8)), zero),
                                       _mm256_cmpeq_epi8(_mm256_or_si256(deficit(0), deficit(8)), zero));
    const __m256i a = _mm256_and_si256(_mm256_cmpeq_epi8(_mm256_or_si256(excess(4), excess(12)), zero),
                                       _mm256_cmpeq_epi8(_mm256_or_si256(deficit(4), deficit(12)), zero));
    if (_mm256_movemask_epi8(_mm256_or_si256(a, b)) == -1) continue;
    // Lengths of the runs of brighter and of darker pixels, once and a half round.
    __m256i run_b = zero;
    __m256i run_d = zero;
    __m256i longest = zero;
    const __m256i one = _mm256_set1_epi8(1);
    for (int k = 0; k < 24; ++k) {
      const __m256i not_b = _mm256_cmpeq_epi8(excess(k & 15), zero);
      const __m256i not_d = _mm256_cmpeq_epi8(deficit(k & 15), zero);
      run_b = _mm256_andnot_si256(not_b, _mm256_add_epi8(run_b, one));
      run_d = _mm256_andnot_si256(not_d, _mm256_add_epi8(run_d, one));
      longest = _mm256_max_epu8(longest, _mm256_max_epu8(run_b, run_d));
    }
    unsigned corners = static_cast<unsigned>(_mm256_movemask_epi8(_mm256_cmpgt_epi8(longest, _mm256_set1_epi8(8))));
    corners &= ~0U << (next - x);
    while (corners != 0) {
      const int i = __builtin_ctz(corners);
      corners &= corners - 1;
      columns[n] = static_cast<std::int16_t>(x + i);
      scores[n++] = static_cast<std::uint8_t>(fast_score(p + i, offsets));
    }
  }
  return n;
}

void sad_row(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length, std::uint16_t* scores) {
  const int blocks = (length + 31) / 32;
  for (int j = 0; j < count; ++j) {
    const std::uint8_t* other = others + static_cast<std::ptrdiff_t>(j) * kDescriptorStride;
    __m256i sum = _mm256_setzero_si256();
    for (int k = 0; k < blocks; ++k) {
      sum = _mm256_add_epi64(sum, _mm256_sad_epu8(load(descriptor + 32 * k), load(other + 32 * k)));
    }
    const __m128i half = _mm_add_epi64(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    scores[j] = static_cast<std::uint16_t>(_mm_cvtsi128_si32(half) + _mm_extract_epi16(half, 4));
  }
}

void patch_sample(const PatchGrid& grid, const std::uint8_t* image, std::ptrdiff_t stride, const PatchPlace& place,
                  float mean, float* samples) {
  const __m256 x = _mm256_set1_ps(place.x), y = _mm256_set1_ps(place.y);
  const __m256 xx = _mm256_set1_ps(place.xx), xy = _mm256_set1_ps(place.xy);
  const __m256 yx = _mm256_set1_ps(place.yx), yy = _mm256_set1_ps(place.yy);
  const __m256i step = _mm256_set1_epi32(static_cast<int>(stride));
  const __m256i byte = _mm256_set1_epi32(255);
  const __m256 level = _mm256_set1_ps(mean);
  const int n = grid.side * grid.side;
  for (int i = 0; i < n; i += kPatchLanes) {
    const __m256 dx = _mm256_load_ps(grid.dx + i), dy = _mm256_load_ps(grid.dy + i);
    const __m256 fx = _mm256_add_ps(_mm256_add_ps(x, _mm256_mul_ps(xx, dx)), _mm256_mul_ps(xy, dy));
    const __m256 fy = _mm256_add_ps(_mm256_add_ps(y, _mm256_mul_ps(yx, dx)), _mm256_mul_ps(yy, dy));
    const __m256i ix = _mm256_cvttps_epi32(fx), iy = _mm256_cvttps_epi32(fy);
    const __m256 ax = _mm256_sub_ps(fx, _mm256_cvtepi32_ps(ix)), ay = _mm256_sub_ps(fy, _mm256_cvtepi32_ps(iy));
    // Each gather brings four neighbours of a row, of which the first two count.
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(iy, step), ix);
    const __m256i p = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image), at, 1);
    const __m256i q = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image + stride), at, 1);
    const __m256i p0 = _mm256_and_si256(p, byte), p1 = _mm256_and_si256(_mm256_srli_epi32(p, 8), byte);
    const __m256i q0 = _mm256_and_si256(q, byte), q1 = _mm256_and_si256(_mm256_srli_epi32(q, 8), byte);
    const __m256 top =
        _mm256_add_ps(_mm256_cvtepi32_ps(p0), _mm256_mul_ps(ax, _mm256_cvtepi32_ps(_mm256_sub_epi32(p1, p0))));
    const __m256 low =
        _mm256_add_ps(_mm256_cvtepi32_ps(q0), _mm256_mul_ps(ax, _mm256_cvtepi32_ps(_mm256_sub_epi32(q1, q0))));
    const __m256 value = _mm256_add_ps(top, _mm256_mul_ps(ay, _mm256_sub_ps(low, top)));
    _mm256_storeu_ps(samples + i, _mm256_sub_ps(value, level));
  }
}

}  // namespace

const Kernels kAvx2Kernels = {fast_row, sad_row, patch_sample, patch_sums_of<VectorFloats>, motion_sums_of<VectorPack>};

}  // namespace cliquevo::vo
