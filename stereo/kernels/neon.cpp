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
  static Reg broadcast8(const std::uint8_t* p) { return vld1q_dup_u8(p); }
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
  // Keys of elements outside [first, last] become the largest.
  static Reg mask(Reg keys, const std::uint16_t* elements, int first, int last) {
    const int16x8_t e = vreinterpretq_s16_u16(vld1q_u16(elements));
    const uint16x8_t low = vcgtq_s16(vdupq_n_s16(static_cast<std::int16_t>(first)), e);
    const uint16x8_t high = vcgtq_s16(e, vdupq_n_s16(static_cast<std::int16_t>(last)));
    return bytes(vorrq_u16(words(keys), vorrq_u16(low, high)));
  }
  // The lane-wise minimum of all keys but the named ones.
  template <int kVectors>
  static Reg least_but(const std::uint16_t* keys, std::uint16_t even_out, std::uint16_t odd_out) {
    static constexpr LeftOut kLeftOut;
    const std::uint16_t* not_even = kLeftOut.slid(even_out);
    const std::uint16_t* not_odd = kLeftOut.slid(odd_out);
    Reg least{};
#pragma GCC unroll 16
    for (int v = 0; v < kVectors; ++v) {
      const Reg a = vorrq_u8(load(keys + v * kBytes), load(not_even + v * kBytes / 2));
      const Reg b = vorrq_u8(load(keys + v * kBytes + kBytes / 2), load(not_odd + v * kBytes / 2));
      least = v == 0 ? min16(a, b) : min16(least, min16(a, b));
    }
    return least;
  }
  static Reg min16(Reg a, Reg b) { return bytes(vminq_u16(words(a), words(b))); }
  // The smallest key, and above 16 bits the lane within eight where it first occurs.
  static unsigned minimum(Reg v) {
    static constexpr std::uint16_t kLanes[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const std::uint16_t least = vminvq_u16(words(v));
    const unsigned lane = vminvq_u16(vornq_u16(vld1q_u16(kLanes), vceqq_u16(words(v), vdupq_n_u16(least))));
    return lane << 16 | least;
  }
};

void match_row(const MatchJob& job) { match_row_with<Neon>(job); }

}  // namespace

const Table kNeon{Isa::neon, kReference.remap_row, vector_prefilter_left, vector_prefilter_right,
                  match_row, vector_smooth};

}  // namespace cliquevo::stereo::kernels
