// SPDX-License-Identifier: BSD-3-Clause
// What the row kernels need of a vector unit, in the intrinsics that SSE and AVX2 share but for their prefix; see
// x86_match.h.

static Reg both(Reg a, Reg b) { return a & b; }
static Reg select(Reg mask, Reg a, Reg b) { return CLIQUEVO_MM(blendv_epi8)(b, a, mask); }
static Reg sub16(Reg a, Reg b) { return CLIQUEVO_MM(sub_epi16)(a, b); }
static Reg mul16(Reg a, Reg b) { return CLIQUEVO_MM(mullo_epi16)(a, b); }
static Reg min16_signed(Reg a, Reg b) { return CLIQUEVO_MM(min_epi16)(a, b); }
static Reg max16_signed(Reg a, Reg b) { return CLIQUEVO_MM(max_epi16)(a, b); }
static Reg abs16(Reg a) { return CLIQUEVO_MM(abs_epi16)(a); }
static Reg equal16(Reg a, Reg b) { return CLIQUEVO_MM(cmpeq_epi16)(a, b); }
static Reg more16(Reg a, Reg b) { return CLIQUEVO_MM(cmpgt_epi16)(a, b); }
static Reg shift_right(Reg a, int n) { return CLIQUEVO_MM(srli_epi16)(a, n); }
static Reg shift_right_signed(Reg a, int n) { return CLIQUEVO_MM(srai_epi16)(a, n); }
// (a * b + 2^14) >> 15
static Reg mul16_high(Reg a, Reg b) { return CLIQUEVO_MM(mulhrs_epi16)(a, b); }
// a where `sign` > 0, -a where it is below, 0 where it is 0
static Reg signed_like(Reg a, Reg sign) { return CLIQUEVO_MM(sign_epi16)(a, sign); }
// Words of a table of eight.
static Reg lookup(Reg table, Reg index) {
  return CLIQUEVO_MM(shuffle_epi8)(table, add16(mul16(index, broadcast16(0x0202)), broadcast16(0x0100)));
}
// All ones where a * weight_a > b * weight_b, for values and weights that are positive signed words.
struct Weights {
  Reg pair;
  Weights(int a, int b) : pair(CLIQUEVO_MM(set1_epi32)(static_cast<int>(static_cast<unsigned>(-b) << 16 | a))) {}
};
static Reg more_weighted(Reg a, Reg b, const Weights& weights) {
  const auto weigh = [&weights](Reg v) {
    return CLIQUEVO_MM(cmpgt_epi32)(CLIQUEVO_MM(madd_epi16)(v, weights.pair), zero());
  };
  return CLIQUEVO_MM(packs_epi32)(weigh(CLIQUEVO_MM(unpacklo_epi16)(a, b)), weigh(CLIQUEVO_MM(unpackhi_epi16)(a, b)));
}
