// SPDX-License-Identifier: BSD-3-Clause
// What the matcher needs of a vector unit, in the intrinsics that SSE, AVX2 and AVX-512 share but for their prefix,
// which CLIQUEVO_MM puts before them. Included inside the struct of each instruction set.

static Reg either(Reg a, Reg b) { return a | b; }
static Reg add8(Reg a, Reg b) { return CLIQUEVO_MM(add_epi8)(a, b); }
static Reg sub8(Reg a, Reg b) { return CLIQUEVO_MM(sub_epi8)(a, b); }
static Reg add16(Reg a, Reg b) { return CLIQUEVO_MM(add_epi16)(a, b); }
static Reg min16(Reg a, Reg b) { return CLIQUEVO_MM(min_epu16)(a, b); }
// Four equal bytes are broadcast as they are loaded, a single one takes an operation.
using Pixel = std::uint32_t;
static Reg broadcast_pixel(const Pixel* p) { return CLIQUEVO_MM(set1_epi32)(static_cast<int>(*p)); }
// n pixels, in steps of 16.
static const Pixel* spread(const std::uint8_t* row, int n, std::uint32_t* out) {
  const __m128i first = _mm_setr_epi8(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
  const __m128i four = _mm_set1_epi8(4);
  for (int x = 0; x < n; x += 16) {
    const __m128i pixels = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row + x));
    __m128i from = first;
    for (int i = 0; i < 16; i += 4, from = _mm_add_epi8(from, four)) {
      _mm_store_si128(reinterpret_cast<__m128i*>(out + x + i), _mm_shuffle_epi8(pixels, from));
    }
  }
  return out;
}
static Reg broadcast16(int v) { return CLIQUEVO_MM(set1_epi16)(static_cast<short>(v)); }
// |a - b| of values below 128.
static Reg difference(Reg a, Reg b) { return CLIQUEVO_MM(abs_epi8)(CLIQUEVO_MM(sub_epi8)(a, b)); }
static Reg factor_even(int weight) { return broadcast16(weight); }
static Reg factor_odd(int weight) { return broadcast16(weight << 8); }
// even, odd += the even and the odd signed bytes of `change`, times the weight.
static void accumulate(Reg& even, Reg& odd, Reg change, Reg factor_even, Reg factor_odd) {
  even = add16(even, CLIQUEVO_MM(maddubs_epi16)(factor_even, change));
  odd = add16(odd, CLIQUEVO_MM(maddubs_epi16)(factor_odd, change));
}
