// SPDX-License-Identifier: BSD-3-Clause
#include <immintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"
#include "stereo/kernels/rows.h"
#include "stereo/kernels/sse4_ops.h"

#define CLIQUEVO_MM(operation) _mm256_##operation

struct Avx2 {
  using Reg = __m256i;
  static constexpr int kBytes = 32;
  static Reg zero() { return _mm256_setzero_si256(); }
  static Reg load(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Reg v) { _mm256_storeu_si256(static_cast<__m256i*>(p), v); }
#include "stereo/kernels/x86_match.h"
#include "stereo/kernels/x86_rows.h"

  static Reg places(int first) {
    return _mm256_set_m128i(_mm_set1_epi16(static_cast<short>(first + 2)), _mm_set1_epi16(static_cast<short>(first)));
  }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) {
    const __m128i m = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return static_cast<unsigned>(_mm_cvtsi128_si32(_mm_minpos_epu16(m)));
  }

  static Reg load_bytes(const std::uint8_t* p) {
    return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
  }
  static void store_bytes(std::uint8_t* p, Reg v) {
    const Reg bytes = _mm256_permute4x64_epi64(_mm256_packus_epi16(v, v), 0x08);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm256_castsi256_si128(bytes));
  }
  static Reg table_of_eight(const std::int16_t* words) {
    return _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(words)));
  }
  // 8 * a / b, rounded to nearest, ties to even; b > 0.
  static Reg eight_times_quotient(Reg a, Reg b) {
    const auto half = [](__m128i n, __m128i d) {
      const __m256 eightfold = _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(n)), _mm256_set1_ps(8.0F));
      return _mm256_cvtps_epi32(_mm256_div_ps(eightfold, _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(d))));
    };
    const Reg low = half(_mm256_castsi256_si128(a), _mm256_castsi256_si128(b));
    const Reg high = half(_mm256_extracti128_si256(a, 1), _mm256_extracti128_si256(b, 1));
    return _mm256_permute4x64_epi64(_mm256_packs_epi32(low, high), 0xD8);
  }
  // A bit for each word of two masks.
  static std::uint64_t bits(Reg first, Reg second) {
    const Reg bytes = _mm256_permute4x64_epi64(_mm256_packs_epi16(first, second), 0xD8);
    return static_cast<unsigned>(_mm256_movemask_epi8(bytes));
  }
};

}  // namespace

void match_row_avx2(const MatchJob& job) { match_row_with<Avx2>(job); }

void use_avx2(Table& table) {
  use_rows<Avx2, Sse4>(table);
  table.match_row = match_row_avx2;
}

}  // namespace cliquevo::stereo::kernels
