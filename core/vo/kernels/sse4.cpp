// SPDX-License-Identifier: BSD-3-Clause
#include <smmintrin.h>

#include "core/vo/kernels/fast_circle.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"
#include "core/vo/kernels/tables.h"

namespace cliquevo::vo {
namespace {

__m128i load(const std::uint8_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }

int fast_row(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::int16_t* columns,
             std::uint8_t* scores) {
  std::ptrdiff_t offsets[16];
  circle_offsets(stride, offsets);
  const __m128i t = _mm_set1_epi8(static_cast<char>(threshold));
  const __m128i zero = _mm_setzero_si128();
  int n = 0;
  if (x1 - x0 < 16) return kReferenceKernels.fast_row(row, stride, x0, x1, threshold, columns, scores);
  for (int next = x0; next < x1; next += 16) {
    const int x = next + 16 <= x1 ? next : x1 - 16;  // the last pack overlaps the one before
    const std::uint8_t* p = row + x;
    const __m128i c = load(p);
    const __m128i above = _mm_adds_epu8(c, t);
    const __m128i below = _mm_subs_epu8(c, t);
    // "not brighter" and "not darker" of a circle pixel, as 0 / nonzero bytes
    const auto excess = [&](int i) { return _mm_subs_epu8(load(p + offsets[i]), above); };
    const auto deficit = [&](int i) { return _mm_subs_epu8(below, load(p + offsets[i])); };
    // Nine contiguous pixels hold at least one of each opposite pair: reject by the four on the axes first.
    const __m128i b = _mm_and_si128(_mm_cmpeq_epi8(_mm_or_si128(excess(0), excess(8)), zero),
                                    _mm_cmpeq_epi8(_mm_or_si128(deficit(0), deficit(8)), zero));
    const __m128i a = _mm_and_si128(_mm_cmpeq_epi8(_mm_or_si128(excess(4), excess(12)), zero),
                                    _mm_cmpeq_epi8(_mm_or_si128(deficit(4), deficit(12)), zero));
    if (_mm_movemask_epi8(_mm_or_si128(a, b)) == 0xffff) continue;
    // Lengths of the runs of brighter and of darker pixels, once and a half round.
    __m128i run_b = zero;
    __m128i run_d = zero;
    __m128i longest = zero;
    const __m128i one = _mm_set1_epi8(1);
    for (int k = 0; k < 24; ++k) {
      const __m128i not_b = _mm_cmpeq_epi8(excess(k & 15), zero);
      const __m128i not_d = _mm_cmpeq_epi8(deficit(k & 15), zero);
      run_b = _mm_andnot_si128(not_b, _mm_add_epi8(run_b, one));
      run_d = _mm_andnot_si128(not_d, _mm_add_epi8(run_d, one));
      longest = _mm_max_epu8(longest, _mm_max_epu8(run_b, run_d));
    }
    unsigned corners = static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpgt_epi8(longest, _mm_set1_epi8(8))));
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
  const int blocks = (length + 15) / 16;
  for (int j = 0; j < count; ++j) {
    const std::uint8_t* other = others + static_cast<std::ptrdiff_t>(j) * kDescriptorStride;
    __m128i sum = _mm_setzero_si128();
    for (int k = 0; k < blocks; ++k) {
      sum = _mm_add_epi64(sum, _mm_sad_epu8(load(descriptor + 16 * k), load(other + 16 * k)));
    }
    scores[j] = static_cast<std::uint16_t>(_mm_cvtsi128_si32(sum) + _mm_extract_epi16(sum, 4));
  }
}

}  // namespace

const Kernels kSse4Kernels = {fast_row, sad_row, patch_sample_plain, patch_sums_of<VectorFloats>,
                              motion_sums_of<VectorPack>};

}  // namespace cliquevo::vo
