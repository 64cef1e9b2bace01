// SPDX-License-Identifier: BSD-3-Clause
#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 takes the undefined registers inside its own intrinsics for a mistake of ours.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

#include <immintrin.h>
#include <type_traits>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"

__extension__ using Uint128 = unsigned __int128;
template <int kVectors>
using LeftOutBits = std::conditional_t<kVectors <= 2, std::uint64_t, Uint128>;

// A bit for each key of one parity that the winner table (Winners::Entry) leaves out. A winner that ends the range is
// thrown away later: bits shifted over an end do not matter.
template <int kVectors>
LeftOutBits<kVectors> left_out(std::uint16_t entry) {
  constexpr unsigned kBits = 8 * sizeof(LeftOutBits<kVectors>);
  const LeftOutBits<kVectors> bits = 1 + 2 * (entry >> 15);
  return bits << ((entry - 1U) & (kBits - 1));
}

struct Avx512 {
  using Reg = __m512i;
  static constexpr int kBytes = 64;
  static Reg zero() { return _mm512_setzero_si512(); }
  static Reg load(const void* p) { return _mm512_loadu_si512(p); }
  static void store(void* p, Reg v) { _mm512_storeu_si512(p, v); }
  static Reg broadcast8(const std::uint8_t* p) { return _mm512_set1_epi8(static_cast<char>(*p)); }
  static Reg add8(Reg a, Reg b) { return _mm512_add_epi8(a, b); }
  static Reg sub8(Reg a, Reg b) { return _mm512_sub_epi8(a, b); }
  // |a - b| of values below 128.
  static Reg difference(Reg a, Reg b) { return _mm512_abs_epi8(_mm512_sub_epi8(a, b)); }
  static Reg factor_even(int weight) { return _mm512_set1_epi16(static_cast<short>(weight)); }
  static Reg factor_odd(int weight) { return _mm512_set1_epi16(static_cast<short>(weight << 8)); }
  // even, odd += the even and the odd signed bytes of `change`, times the weight.
  static void accumulate(Reg& even, Reg& odd, Reg change, Reg factor_even, Reg factor_odd) {
    even = _mm512_add_epi16(even, _mm512_maddubs_epi16(factor_even, change));
    odd = _mm512_add_epi16(odd, _mm512_maddubs_epi16(factor_odd, change));
  }
  static Reg places(int first) {
    const auto lane = [first](int i) { return (first + 2 * i) * 0x00010001; };
    return _mm512_set_epi32(lane(3), lane(3), lane(3), lane(3), lane(2), lane(2), lane(2), lane(2), lane(1), lane(1),
                            lane(1), lane(1), lane(0), lane(0), lane(0), lane(0));
  }
  // Keys of elements outside [first, last] become the largest.
  static Reg mask(Reg keys, const std::uint16_t* elements, int first, int last) {
    const Reg e = load(elements);
    const __mmask32 low = _mm512_cmpgt_epi16_mask(_mm512_set1_epi16(static_cast<short>(first)), e);
    const __mmask32 high = _mm512_cmpgt_epi16_mask(e, _mm512_set1_epi16(static_cast<short>(last)));
    return _mm512_mask_mov_epi16(keys, low | high, _mm512_set1_epi16(-1));
  }
  // The lane-wise minimum of all keys but the named ones.
  template <int kVectors>
  static Reg least_but(const std::uint16_t* keys, std::uint16_t even_out, std::uint16_t odd_out) {
    const LeftOutBits<kVectors> not_even = left_out<kVectors>(even_out);
    const LeftOutBits<kVectors> not_odd = left_out<kVectors>(odd_out);
    Reg least = _mm512_set1_epi16(-1);
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      least =
          _mm512_mask_min_epu16(least, ~static_cast<__mmask32>(not_even >> (32 * v)), least, load(keys + v * kBytes));
      least = _mm512_mask_min_epu16(least, ~static_cast<__mmask32>(not_odd >> (32 * v)), least,
                                    load(keys + v * kBytes + kBytes / 2));
    }
    return least;
  }
  static Reg min16(Reg a, Reg b) { return _mm512_min_epu16(a, b); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) {
    const __m256i half = _mm256_min_epu16(_mm512_castsi512_si256(v), _mm512_extracti64x4_epi64(v, 1));
    const __m128i m = _mm_min_epu16(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1));
    return static_cast<unsigned>(_mm_cvtsi128_si32(_mm_minpos_epu16(m)));
  }
};

void match_row(const MatchJob& job) {
  switch (padded_disparities(job.num_disparities) / 32) {
    case 2:
      return RowMatcher<Avx512, 1>(job).run();
    case 4:
      return RowMatcher<Avx512, 2>(job).run();
    case 6:
      return RowMatcher<Avx512, 3>(job).run();
    case 8:
      return RowMatcher<Avx512, 4>(job).run();
    default:
      return kAvx2.match_row(job);
  }
}

}  // namespace

const Table kAvx512{Isa::avx512,           kAvx2.remap_row, kAvx2.prefilter_left,
                    kAvx2.prefilter_right, match_row,       kAvx2.smooth_row};

}  // namespace cliquevo::stereo::kernels
