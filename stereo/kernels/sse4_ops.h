// SPDX-License-Identifier: BSD-3-Clause
// The operations of 128-bit vectors on x86. Included inside an anonymous namespace, also by AVX2, which rectifies with
// them.

#define CLIQUEVO_MM(operation) _mm_##operation

struct Sse4 {
  using Reg = __m128i;
  static constexpr int kBytes = 16;
  static Reg zero() { return _mm_setzero_si128(); }
  static Reg load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static void store(void* p, Reg v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }
#include "stereo/kernels/x86_match.h"
#include "stereo/kernels/x86_rows.h"

  static Reg places(int first) { return broadcast16(first); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) { return static_cast<unsigned>(_mm_cvtsi128_si32(_mm_minpos_epu16(v))); }

  static Reg load_half(const std::uint8_t* p) { return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)); }
  // Bytes of a and b taking turns, from the low halves.
  static Reg interleave(Reg a, Reg b) { return _mm_unpacklo_epi8(a, b); }
  static Reg shuffle(Reg bytes, Reg from) { return _mm_shuffle_epi8(bytes, from); }
  // Pairs of bytes, each times its own weight below 128.
  static Reg weighted_pairs(Reg bytes, Reg weights) { return _mm_maddubs_epi16(bytes, weights); }
  static Reg load_bytes(const std::uint8_t* p) {
    return _mm_cvtepu8_epi16(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
  }
  static void store_bytes(std::uint8_t* p, Reg v) {
    _mm_storel_epi64(reinterpret_cast<__m128i*>(p), _mm_packus_epi16(v, v));
  }
  static Reg table_of_eight(const std::int16_t* words) { return load(words); }
  // 8 * a / b, rounded to nearest, ties to even; b > 0.
  static Reg eight_times_quotient(Reg a, Reg b) {
    const auto half = [](Reg n, Reg d) {
      const __m128 eightfold = _mm_mul_ps(_mm_cvtepi32_ps(_mm_cvtepi16_epi32(n)), _mm_set1_ps(8.0F));
      return _mm_cvtps_epi32(_mm_div_ps(eightfold, _mm_cvtepi32_ps(_mm_cvtepi16_epi32(d))));
    };
    return _mm_packs_epi32(half(a, b), half(_mm_srli_si128(a, 8), _mm_srli_si128(b, 8)));
  }
  // A bit for each word of two masks.
  static std::uint64_t bits(Reg first, Reg second) {
    return static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(first, second)));
  }
};

#undef CLIQUEVO_MM
