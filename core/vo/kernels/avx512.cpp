// SPDX-License-Identifier: BSD-3-Clause
// Bytes in registers of 64; all else as for AVX2, by a compiler that has twice as many registers to spread it over.
#include <immintrin.h>

#include "core/vo/kernels/avx_patches.h"
#include "core/vo/kernels/byte_rows.h"
#include "core/vo/kernels/graph_rows.h"
#include "core/vo/kernels/motion_sums.h"

namespace cliquevo::vo {
namespace {

struct Avx512Bytes {
  using Reg = __m512i;
  static constexpr int kBytes = 64;
  static Reg zero() { return _mm512_setzero_si512(); }
  static Reg load(const void* p) { return _mm512_loadu_si512(p); }
  static void store(void* p, Reg v) { _mm512_storeu_si512(p, v); }
  static Reg broadcast8(int v) { return _mm512_set1_epi8(static_cast<char>(v)); }
  static Reg broadcast16(int v) { return _mm512_set1_epi16(static_cast<short>(v)); }
  static Reg min8(Reg a, Reg b) { return _mm512_min_epu8(a, b); }
  static Reg max8(Reg a, Reg b) { return _mm512_max_epu8(a, b); }
  static Reg min16(Reg a, Reg b) { return _mm512_min_epu16(a, b); }
  static Reg equal16(Reg a, Reg b) { return _mm512_movm_epi16(_mm512_cmpeq_epi16_mask(a, b)); }
  static Reg select(Reg mask, Reg a, Reg b) { return _mm512_mask_blend_epi8(_mm512_movepi8_mask(mask), b, a); }
  static Reg subtract_saturated(Reg a, Reg b) { return _mm512_subs_epu8(a, b); }
  static Reg equal8(Reg a, Reg b) { return _mm512_movm_epi8(_mm512_cmpeq_epi8_mask(a, b)); }
  static constexpr int kBitsPerByte = 1;
  static std::uint64_t bits(Reg mask) { return _mm512_movepi8_mask(mask); }
  static bool any(Reg mask) { return _mm512_movepi8_mask(mask) != 0; }
  static bool any_above(Reg a, Reg b) { return _mm512_cmpgt_epu8_mask(a, b) != 0; }
  static Reg sad(Reg a, Reg b) { return _mm512_sad_epu8(a, b); }
  static Reg add64(Reg a, Reg b) { return _mm512_add_epi64(a, b); }
  // Four sums, each still in parts below 2^16.
  static void store_four(std::uint16_t* to, Reg a, Reg b, Reg c, Reg d) {
    const Reg all = _mm512_or_si512(_mm512_or_si512(a, _mm512_slli_epi64(b, 16)),
                                    _mm512_or_si512(_mm512_slli_epi64(c, 32), _mm512_slli_epi64(d, 48)));
    const __m256i quarter = _mm256_add_epi16(_mm512_castsi512_si256(all), _mm512_extracti64x4_epi64(all, 1));
    const __m128i half = _mm_add_epi16(_mm256_castsi256_si128(quarter), _mm256_extracti128_si256(quarter, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_add_epi16(half, _mm_unpackhi_epi64(half, half)));
  }
};

}  // namespace

void use_avx512(Kernels& table) {
  table.fast_row = fast_row_of<Avx512Bytes>;
  table.maxima_row = maxima_row_of<Avx512Bytes>;
  table.sad_row = sad_row_of<Avx512Bytes>;
  table.row_minimum = row_minimum_of<Avx512Bytes>;
  table.graph_row = graph_row_of<VectorFloats>;
  table.patch_cut = patch_cut;
  table.patch_sums = patch_sums<true>;
  table.patch_sums_across = patch_sums<false>;
  table.motion_sums = motion_sums_of<VectorPack>;
}

}  // namespace cliquevo::vo
