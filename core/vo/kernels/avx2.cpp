// SPDX-License-Identifier: BSD-3-Clause
#include <immintrin.h>

#include "core/vo/kernels/avx_patches.h"
#include "core/vo/kernels/byte_rows.h"
#include "core/vo/kernels/graph_rows.h"
#include "core/vo/kernels/motion_sums.h"

namespace cliquevo::vo {
namespace {

struct Avx2Bytes {
  using Reg = __m256i;
  static constexpr int kBytes = 32;
  static Reg zero() { return _mm256_setzero_si256(); }
  static Reg load(const void* p) { return _mm256_loadu_si256(static_cast<const __m256i*>(p)); }
  static void store(void* p, Reg v) { _mm256_storeu_si256(static_cast<__m256i*>(p), v); }
  static Reg broadcast8(int v) { return _mm256_set1_epi8(static_cast<char>(v)); }
  static Reg broadcast16(int v) { return _mm256_set1_epi16(static_cast<short>(v)); }
  static Reg min8(Reg a, Reg b) { return _mm256_min_epu8(a, b); }
  static Reg max8(Reg a, Reg b) { return _mm256_max_epu8(a, b); }
  static Reg min16(Reg a, Reg b) { return _mm256_min_epu16(a, b); }
  static Reg equal16(Reg a, Reg b) { return _mm256_cmpeq_epi16(a, b); }
  static Reg select(Reg mask, Reg a, Reg b) { return _mm256_blendv_epi8(b, a, mask); }
  static Reg subtract_saturated(Reg a, Reg b) { return _mm256_subs_epu8(a, b); }
  static Reg equal8(Reg a, Reg b) { return _mm256_cmpeq_epi8(a, b); }
  static constexpr int kBitsPerByte = 1;
  static std::uint64_t bits(Reg mask) { return static_cast<std::uint32_t>(_mm256_movemask_epi8(mask)); }
  static bool any(Reg mask) { return _mm256_movemask_epi8(mask) != 0; }
  static bool any_above(Reg a, Reg b) { return _mm256_testz_si256(subtract_saturated(a, b), broadcast8(-1)) == 0; }
  static Reg sad(Reg a, Reg b) { return _mm256_sad_epu8(a, b); }
  static Reg add64(Reg a, Reg b) { return _mm256_add_epi64(a, b); }
  // Four sums, each still in parts below 2^16.
  static void store_four(std::uint16_t* to, Reg a, Reg b, Reg c, Reg d) {
    const Reg all = _mm256_or_si256(_mm256_or_si256(a, _mm256_slli_epi64(b, 16)),
                                    _mm256_or_si256(_mm256_slli_epi64(c, 32), _mm256_slli_epi64(d, 48)));
    const __m128i half = _mm_add_epi16(_mm256_castsi256_si128(all), _mm256_extracti128_si256(all, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_add_epi16(half, _mm_unpackhi_epi64(half, half)));
  }
};

}  // namespace

void use_avx2(Kernels& table) {
  table.fast_row = fast_row_of<Avx2Bytes>;
  table.maxima_row = maxima_row_of<Avx2Bytes>;
  table.sad_row = sad_row_of<Avx2Bytes>;
  table.row_minimum = row_minimum_of<Avx2Bytes>;
  table.graph_row = graph_row_of<VectorFloats>;
  table.patch_cut = patch_cut;
  table.patch_sums = patch_sums<true>;
  table.patch_sums_across = patch_sums<false>;
  table.motion_sums = motion_sums_of<VectorPack>;
}

}  // namespace cliquevo::vo
