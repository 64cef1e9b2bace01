// SPDX-License-Identifier: BSD-3-Clause
#include <smmintrin.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"

struct Sse4 {
  using Reg = __m128i;
  static constexpr int kBytes = 16;
  static Reg zero() { return _mm_setzero_si128(); }
  static Reg load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static void store(void* p, Reg v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }
  static Reg broadcast8(std::uint8_t v) { return _mm_set1_epi8(static_cast<char>(v)); }
  static Reg add8(Reg a, Reg b) { return _mm_add_epi8(a, b); }
  static Reg sub8(Reg a, Reg b) { return _mm_sub_epi8(a, b); }
  static Reg difference(Reg a, Reg b) { return _mm_abs_epi8(_mm_sub_epi8(a, b)); }
  static Reg factors(int weight) { return _mm_set1_epi16(static_cast<short>(weight | ((-weight & 0xFF) << 8))); }
  static void accumulate(Reg& lo, Reg& hi, Reg in, Reg out, Reg f) {
    lo = _mm_add_epi16(lo, _mm_maddubs_epi16(_mm_unpacklo_epi8(in, out), f));
    hi = _mm_add_epi16(hi, _mm_maddubs_epi16(_mm_unpackhi_epi8(in, out), f));
  }
  static Reg min16(Reg a, Reg b) { return _mm_min_epu16(a, b); }
  static int minimum(Reg v, int& lane) {
    const int found = _mm_cvtsi128_si32(_mm_minpos_epu16(v));
    lane = found >> 16 & 7;
    return found & 0xFFFF;
  }
};

void match_row(const MatchJob& job) { RowMatcher<Sse4>(job).run(); }

}  // namespace

const Table kSse4{Isa::sse4, kReference.remap_row, kReference.prefilter_row, match_row};

}  // namespace cliquevo::stereo::kernels
