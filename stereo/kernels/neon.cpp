// SPDX-License-Identifier: BSD-3-Clause
#include <arm_neon.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"
#include "stereo/kernels/rows.h"

struct Neon {
  using Reg = uint8x16_t;
  static constexpr int kBytes = 16;
  static uint16x8_t words(Reg v) { return vreinterpretq_u16_u8(v); }
  static Reg bytes(uint16x8_t v) { return vreinterpretq_u8_u16(v); }
  static Reg zero() { return vdupq_n_u8(0); }
  static Reg load(const void* p) { return vld1q_u8(static_cast<const std::uint8_t*>(p)); }
  static void store(void* p, Reg v) { vst1q_u8(static_cast<std::uint8_t*>(p), v); }
  using Pixel = std::uint8_t;
  static Reg broadcast_pixel(const Pixel* p) { return vld1q_dup_u8(p); }
  static const Pixel* spread(const std::uint8_t* row, int /*n*/, std::uint32_t* /*out*/) { return row; }
  static Reg add8(Reg a, Reg b) { return vaddq_u8(a, b); }
  static Reg sub8(Reg a, Reg b) { return vsubq_u8(a, b); }
  static Reg difference(Reg a, Reg b) { return vabdq_u8(a, b); }
  static Reg factor_even(int weight) { return vdupq_n_u8(static_cast<std::uint8_t>(weight)); }
  static Reg factor_odd(int weight) { return factor_even(weight); }
  // even, odd += the even and the odd signed bytes of `change`, times the weight.
  static void accumulate(Reg& even, Reg& odd, Reg change, Reg factor, Reg /*factor_odd*/) {
    const int8x16_t c = vreinterpretq_s8_u8(change);
    const int8x8_t f = vget_low_s8(vreinterpretq_s8_u8(factor));
    const int8x16_t sorted = vcombine_s8(vget_low_s8(vuzp1q_s8(c, c)), vget_low_s8(vuzp2q_s8(c, c)));
    even = bytes(vreinterpretq_u16_s16(vmlal_s8(vreinterpretq_s16_u16(words(even)), vget_low_s8(sorted), f)));
    odd = bytes(vreinterpretq_u16_s16(vmlal_s8(vreinterpretq_s16_u16(words(odd)), vget_high_s8(sorted), f)));
  }
  static Reg places(int first) { return bytes(vdupq_n_u16(static_cast<std::uint16_t>(first))); }
  static Reg min16(Reg a, Reg b) { return bytes(vminq_u16(words(a), words(b))); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) {
    static constexpr std::uint16_t kLanes[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const std::uint16_t least = vminvq_u16(words(v));
    const unsigned lane = vminvq_u16(vornq_u16(vld1q_u16(kLanes), vceqq_u16(words(v), vdupq_n_u16(least))));
    return lane << 16 | least;
  }

  static int16x8_t shorts(Reg v) { return vreinterpretq_s16_u8(v); }
  static Reg bytes(int16x8_t v) { return vreinterpretq_u8_s16(v); }
  static Reg broadcast16(int v) { return bytes(vdupq_n_s16(static_cast<std::int16_t>(v))); }
  static Reg both(Reg a, Reg b) { return vandq_u8(a, b); }
  static Reg either(Reg a, Reg b) { return vorrq_u8(a, b); }
  static Reg select(Reg mask, Reg a, Reg b) { return vbslq_u8(mask, a, b); }
  static Reg add16(Reg a, Reg b) { return bytes(vaddq_s16(shorts(a), shorts(b))); }
  static Reg sub16(Reg a, Reg b) { return bytes(vsubq_s16(shorts(a), shorts(b))); }
  static Reg mul16(Reg a, Reg b) { return bytes(vmulq_s16(shorts(a), shorts(b))); }
  static Reg min16_signed(Reg a, Reg b) { return bytes(vminq_s16(shorts(a), shorts(b))); }
  static Reg max16_signed(Reg a, Reg b) { return bytes(vmaxq_s16(shorts(a), shorts(b))); }
  static Reg abs16(Reg a) { return bytes(vabsq_s16(shorts(a))); }
  static Reg equal16(Reg a, Reg b) { return bytes(vceqq_s16(shorts(a), shorts(b))); }
  static Reg more16(Reg a, Reg b) { return bytes(vcgtq_s16(shorts(a), shorts(b))); }
  static Reg shift_right(Reg a, int n) {
    return bytes(vshlq_u16(words(a), vdupq_n_s16(static_cast<std::int16_t>(-n))));
  }
  static Reg shift_right_signed(Reg a, int n) {
    return bytes(vshlq_s16(shorts(a), vdupq_n_s16(static_cast<std::int16_t>(-n))));
  }
  // (a * b + 2^14) >> 15
  static Reg mul16_high(Reg a, Reg b) { return bytes(vqrdmulhq_s16(shorts(a), shorts(b))); }
  // a where `sign` > 0, -a where it is below, 0 where it is 0
  static Reg signed_like(Reg a, Reg sign) {
    const Reg turned = vbslq_u8(bytes(vcltzq_s16(shorts(sign))), bytes(vnegq_s16(shorts(a))), a);
    return vbicq_u8(turned, bytes(vceqzq_s16(shorts(sign))));
  }
  static Reg load_half(const std::uint8_t* p) { return vcombine_u8(vld1_u8(p), vdup_n_u8(0)); }
  static Reg load_bytes(const std::uint8_t* p) { return bytes(vmovl_u8(vld1_u8(p))); }
  static void store_bytes(std::uint8_t* p, Reg v) { vst1_u8(p, vmovn_u16(words(v))); }
  static Reg interleave(Reg a, Reg b) { return vzip1q_u8(a, b); }
  static Reg shuffle(Reg bytes, Reg from) { return vqtbl1q_u8(bytes, from); }
  // Pairs of bytes, each times its own weight.
  static Reg weighted_pairs(Reg pixels, Reg weights) {
    const uint16x8_t low = vmull_u8(vget_low_u8(pixels), vget_low_u8(weights));
    return bytes(vpaddq_u16(low, vmull_high_u8(pixels, weights)));
  }
  static Reg table_of_eight(const std::int16_t* words) { return bytes(vld1q_s16(words)); }
  static Reg lookup(Reg table, Reg index) {
    return vqtbl1q_u8(table, add16(mul16(index, broadcast16(0x0202)), broadcast16(0x0100)));
  }
  // All ones where a * weight_a > b * weight_b, for values and weights that are positive signed words.
  struct Weights {
    std::uint16_t a, b;
    Weights(int of_a, int of_b) : a(static_cast<std::uint16_t>(of_a)), b(static_cast<std::uint16_t>(of_b)) {}
  };
  static Reg more_weighted(Reg a, Reg b, const Weights& weights) {
    const auto half = [&weights](uint16x4_t x, uint16x4_t y) {
      return vmovn_u32(vcgtq_u32(vmull_n_u16(x, weights.a), vmull_n_u16(y, weights.b)));
    };
    return bytes(vcombine_u16(half(vget_low_u16(words(a)), vget_low_u16(words(b))),
                              half(vget_high_u16(words(a)), vget_high_u16(words(b)))));
  }
  // 8 * a / b, rounded to nearest, ties to even; b > 0.
  static Reg eight_times_quotient(Reg a, Reg b) {
    const auto half = [](int16x4_t n, int16x4_t d) {
      const float32x4_t eightfold = vmulq_n_f32(vcvtq_f32_s32(vmovl_s16(n)), 8.0F);
      return vmovn_s32(vcvtnq_s32_f32(vdivq_f32(eightfold, vcvtq_f32_s32(vmovl_s16(d)))));
    };
    return bytes(vcombine_s16(half(vget_low_s16(shorts(a)), vget_low_s16(shorts(b))),
                              half(vget_high_s16(shorts(a)), vget_high_s16(shorts(b)))));
  }
  // A bit for each word of two masks.
  static std::uint64_t bits(Reg first, Reg second) {
    static constexpr std::uint8_t kBits[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    const uint8x8_t bit = vld1_u8(kBits);
    return vaddv_u8(vand_u8(vmovn_u16(words(first)), bit)) |
           static_cast<std::uint64_t>(vaddv_u8(vand_u8(vmovn_u16(words(second)), bit))) << 8;
  }
};

void match_row(const MatchJob& job) { match_row_with<Neon>(job); }

}  // namespace

void use_neon(Table& table) {
  use_rows<Neon, Neon>(table);
  table.match_row = match_row;
}

}  // namespace cliquevo::stereo::kernels
