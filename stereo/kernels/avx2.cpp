// SPDX-License-Identifier: BSD-3-Clause
#include <immintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"

struct Avx2 {
  using Reg = __m256i;
  static constexpr int kBytes = 32;
  static Reg zero() { return _mm256_setzero_si256(); }
  static Reg load(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Reg v) { _mm256_storeu_si256(static_cast<__m256i*>(p), v); }
  static Reg broadcast8(std::uint8_t v) { return _mm256_set1_epi8(static_cast<char>(v)); }
  static Reg add8(Reg a, Reg b) { return _mm256_add_epi8(a, b); }
  static Reg sub8(Reg a, Reg b) { return _mm256_sub_epi8(a, b); }
  // |a - b| of values below 128.
  static Reg difference(Reg a, Reg b) { return _mm256_abs_epi8(_mm256_sub_epi8(a, b)); }
  static Reg factors(int weight) { return _mm256_set1_epi16(static_cast<short>(weight | ((-weight & 0xFF) << 8))); }
  // lo, hi += (in - out) * weight, bytes to words.
  static void accumulate(Reg& lo, Reg& hi, Reg in, Reg out, Reg f) {
    lo = _mm256_add_epi16(lo, _mm256_maddubs_epi16(_mm256_unpacklo_epi8(in, out), f));
    hi = _mm256_add_epi16(hi, _mm256_maddubs_epi16(_mm256_unpackhi_epi8(in, out), f));
  }
  static Reg min16(Reg a, Reg b) { return _mm256_min_epu16(a, b); }
  static int minimum(Reg v, int& lane) {
    const __m128i m = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const int found = _mm_cvtsi128_si32(_mm_minpos_epu16(m));
    lane = found >> 16 & 7;
    return found & 0xFFFF;
  }
};

void match_row(const MatchJob& job) { RowMatcher<Avx2>(job).run(); }

}  // namespace

const Table kAvx2{Isa::avx2, kReference.remap_row, kReference.prefilter_row, match_row};

}  // namespace cliquevo::stereo::kernels
