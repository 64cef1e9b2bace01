// SPDX-License-Identifier: BSD-3-Clause
#include <smmintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"
#include "stereo/kernels/rows.h"

struct Sse4 {
  using Reg = __m128i;
  static constexpr int kBytes = 16;
  static Reg zero() { return _mm_setzero_si128(); }
  static Reg load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static void store(void* p, Reg v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }
  static Reg broadcast8(const std::uint8_t* p) { return _mm_set1_epi8(static_cast<char>(*p)); }
  static Reg add8(Reg a, Reg b) { return _mm_add_epi8(a, b); }
  static Reg sub8(Reg a, Reg b) { return _mm_sub_epi8(a, b); }
  // |a - b| of values below 128.
  static Reg difference(Reg a, Reg b) { return _mm_abs_epi8(_mm_sub_epi8(a, b)); }
  static Reg factor_even(int weight) { return _mm_set1_epi16(static_cast<short>(weight)); }
  static Reg factor_odd(int weight) { return _mm_set1_epi16(static_cast<short>(weight << 8)); }
  // even, odd += the even and the odd signed bytes of `change`, times the weight.
  static void accumulate(Reg& even, Reg& odd, Reg change, Reg factor_even, Reg factor_odd) {
    even = _mm_add_epi16(even, _mm_maddubs_epi16(factor_even, change));
    odd = _mm_add_epi16(odd, _mm_maddubs_epi16(factor_odd, change));
  }
  static Reg places(int first) { return _mm_set1_epi16(static_cast<short>(first)); }
  // Keys of elements outside [first, last] become the largest.
  static Reg mask(Reg keys, const std::uint16_t* elements, int first, int last) {
    const Reg e = load(elements);
    const Reg low = _mm_cmpgt_epi16(_mm_set1_epi16(static_cast<short>(first)), e);
    const Reg high = _mm_cmpgt_epi16(e, _mm_set1_epi16(static_cast<short>(last)));
    return _mm_or_si128(keys, _mm_or_si128(low, high));
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
      const Reg a = _mm_or_si128(load(keys + v * kBytes), load(not_even + v * kBytes / 2));
      const Reg b = _mm_or_si128(load(keys + v * kBytes + kBytes / 2), load(not_odd + v * kBytes / 2));
      least = v == 0 ? min16(a, b) : min16(least, min16(a, b));
    }
    return least;
  }
  static Reg min16(Reg a, Reg b) { return _mm_min_epu16(a, b); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) { return static_cast<unsigned>(_mm_cvtsi128_si32(_mm_minpos_epu16(v))); }
};

void match_row(const MatchJob& job) { match_row_with<Sse4>(job); }

}  // namespace

const Table kSse4{Isa::sse4, kReference.remap_row, vector_prefilter_left, vector_prefilter_right,
                  match_row, vector_smooth};

}  // namespace cliquevo::stereo::kernels
