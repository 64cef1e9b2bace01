// SPDX-License-Identifier: BSD-3-Clause
#include <smmintrin.h>

#include "core/vo/kernels/byte_rows.h"
#include "core/vo/kernels/graph_rows.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"

namespace cliquevo::vo {
namespace {

struct Sse4Bytes {
  using Reg = __m128i;
  static constexpr int kBytes = 16;
  static Reg zero() { return _mm_setzero_si128(); }
  static Reg load(const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }
  static void store(void* p, Reg v) { _mm_storeu_si128(static_cast<__m128i*>(p), v); }
  static Reg broadcast8(int v) { return _mm_set1_epi8(static_cast<char>(v)); }
  static Reg broadcast16(int v) { return _mm_set1_epi16(static_cast<short>(v)); }
  static Reg min8(Reg a, Reg b) { return _mm_min_epu8(a, b); }
  static Reg max8(Reg a, Reg b) { return _mm_max_epu8(a, b); }
  static Reg min16(Reg a, Reg b) { return _mm_min_epu16(a, b); }
  static Reg equal16(Reg a, Reg b) { return _mm_cmpeq_epi16(a, b); }
  static Reg select(Reg mask, Reg a, Reg b) { return _mm_blendv_epi8(b, a, mask); }
  static Reg subtract_saturated(Reg a, Reg b) { return _mm_subs_epu8(a, b); }
  static Reg equal8(Reg a, Reg b) { return _mm_cmpeq_epi8(a, b); }
  static constexpr int kBitsPerByte = 1;
  static std::uint64_t bits(Reg mask) { return static_cast<std::uint32_t>(_mm_movemask_epi8(mask)); }
  static bool any(Reg mask) { return _mm_movemask_epi8(mask) != 0; }
  static bool any_above(Reg a, Reg b) { return _mm_testz_si128(subtract_saturated(a, b), broadcast8(-1)) == 0; }
  static Reg sad(Reg a, Reg b) { return _mm_sad_epu8(a, b); }
  static Reg add64(Reg a, Reg b) { return _mm_add_epi64(a, b); }
  // Four sums, each still in parts below 2^16.
  static void store_four(std::uint16_t* to, Reg a, Reg b, Reg c, Reg d) {
    const Reg all = _mm_or_si128(_mm_or_si128(a, _mm_slli_epi64(b, 16)),
                                 _mm_or_si128(_mm_slli_epi64(c, 32), _mm_slli_epi64(d, 48)));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_add_epi16(all, _mm_unpackhi_epi64(all, all)));
  }
};

}  // namespace

void use_sse4(Kernels& table) {
  table.fast_row = fast_row_of<Sse4Bytes>;
  table.maxima_row = maxima_row_of<Sse4Bytes>;
  table.sad_row = sad_row_of<Sse4Bytes>;
  table.row_minimum = row_minimum_of<Sse4Bytes>;
  table.graph_row = graph_row_of<VectorFloats>;
  table.patch_cut = patch_cut_of<VectorFloats>;
  table.patch_sums = patch_sums_of<VectorFloats, true>;
  table.patch_sums_across = patch_sums_of<VectorFloats, false>;
  table.motion_sums = motion_sums_of<VectorPack>;
}

}  // namespace cliquevo::vo
