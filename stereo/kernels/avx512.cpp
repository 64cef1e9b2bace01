// SPDX-License-Identifier: BSD-3-Clause
#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 takes the undefined registers inside its own intrinsics for a mistake of ours.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

#include <immintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"

#define CLIQUEVO_MM(operation) _mm512_##operation

struct Avx512 {
  using Reg = __m512i;
  static constexpr int kBytes = 64;
  static Reg zero() { return _mm512_setzero_si512(); }
  static Reg load(const void* p) { return _mm512_loadu_si512(p); }
  static void store(void* p, Reg v) { _mm512_storeu_si512(p, v); }
#include "stereo/kernels/x86_match.h"

  static Reg places(int first) {
    const auto lane = [first](int i) { return (first + 2 * i) * 0x00010001; };
    return _mm512_set_epi32(lane(3), lane(3), lane(3), lane(3), lane(2), lane(2), lane(2), lane(2), lane(1), lane(1),
                            lane(1), lane(1), lane(0), lane(0), lane(0), lane(0));
  }
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
      return match_row_avx2(job);
  }
}

}  // namespace

// The row kernels are short of memory, not of width.
void use_avx512(Table& table) { table.match_row = match_row; }

}  // namespace cliquevo::stereo::kernels
