// SPDX-License-Identifier: BSD-3-Clause
#include <immintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"
#include "stereo/kernels/rows.h"

struct Avx2 {
  using Reg = __m256i;
  static constexpr int kBytes = 32;
  static Reg zero() { return _mm256_setzero_si256(); }
  static Reg load(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Reg v) { _mm256_storeu_si256(static_cast<__m256i*>(p), v); }
  static Reg broadcast8(const std::uint8_t* p) { return _mm256_set1_epi8(static_cast<char>(*p)); }
  static Reg add8(Reg a, Reg b) { return _mm256_add_epi8(a, b); }
  static Reg sub8(Reg a, Reg b) { return _mm256_sub_epi8(a, b); }
  // |a - b| of values below 128.
  static Reg difference(Reg a, Reg b) { return _mm256_abs_epi8(_mm256_sub_epi8(a, b)); }
  static Reg factor_even(int weight) { return _mm256_set1_epi16(static_cast<short>(weight)); }
  static Reg factor_odd(int weight) { return _mm256_set1_epi16(static_cast<short>(weight << 8)); }
  // even, odd += the even and the odd signed bytes of `change`, times the weight.
  static void accumulate(Reg& even, Reg& odd, Reg change, Reg factor_even, Reg factor_odd) {
    even = _mm256_add_epi16(even, _mm256_maddubs_epi16(factor_even, change));
    odd = _mm256_add_epi16(odd, _mm256_maddubs_epi16(factor_odd, change));
  }
  static Reg places(int first) {
    return _mm256_set_m128i(_mm_set1_epi16(static_cast<short>(first + 2)), _mm_set1_epi16(static_cast<short>(first)));
  }
  // Keys of elements outside [first, last] become the largest.
  static Reg mask(Reg keys, const std::uint16_t* elements, int first, int last) {
    const Reg e = load(elements);
    const Reg low = _mm256_cmpgt_epi16(_mm256_set1_epi16(static_cast<short>(first)), e);
    const Reg high = _mm256_cmpgt_epi16(e, _mm256_set1_epi16(static_cast<short>(last)));
    return _mm256_or_si256(keys, _mm256_or_si256(low, high));
  }
  // The lane-wise minimum of all keys but the named ones.
  template <int kVectors>
  static Reg least_but(const std::uint16_t* keys, std::uint16_t even_out, std::uint16_t odd_out) {
    static constexpr LeftOut kLeftOut;
    const std::uint16_t* not_even = kLeftOut.slid(even_out);
    const std::uint16_t* not_odd = kLeftOut.slid(odd_out);
    Reg least{};
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) {
      const Reg a = _mm256_or_si256(load(keys + v * kBytes), load(not_even + v * kBytes / 2));
      const Reg b = _mm256_or_si256(load(keys + v * kBytes + kBytes / 2), load(not_odd + v * kBytes / 2));
      least = v == 0 ? min16(a, b) : min16(least, min16(a, b));
    }
    return least;
  }
  static Reg min16(Reg a, Reg b) { return _mm256_min_epu16(a, b); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) {
    const __m128i m = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return static_cast<unsigned>(_mm_cvtsi128_si32(_mm_minpos_epu16(m)));
  }
};

void match_row(const MatchJob& job) { match_row_with<Avx2>(job); }

}  // namespace

const Table kAvx2{Isa::avx2, kReference.remap_row, vector_prefilter_left, vector_prefilter_right,
                  match_row, vector_smooth};

}  // namespace cliquevo::stereo::kernels
