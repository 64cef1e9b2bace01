// SPDX-License-Identifier: BSD-3-Clause
#include <arm_neon.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {

namespace {

#include "stereo/kernels/match_row.h"

struct Neon {
  using Reg = uint8x16_t;
  static constexpr int kBytes = 16;
  static Reg zero() { return vdupq_n_u8(0); }
  static Reg load(const void* p) { return vld1q_u8(static_cast<const std::uint8_t*>(p)); }
  static void store(void* p, Reg v) { vst1q_u8(static_cast<std::uint8_t*>(p), v); }
  static Reg broadcast8(std::uint8_t v) { return vdupq_n_u8(v); }
  static Reg add8(Reg a, Reg b) { return vaddq_u8(a, b); }
  static Reg sub8(Reg a, Reg b) { return vsubq_u8(a, b); }
  static Reg difference(Reg a, Reg b) { return vabdq_u8(a, b); }
  static Reg factors(int weight) { return vreinterpretq_u8_u16(vdupq_n_u16(static_cast<std::uint16_t>(weight))); }
  static void accumulate(Reg& lo, Reg& hi, Reg in, Reg out, Reg f) {
    const uint16x8_t w = vreinterpretq_u16_u8(f);
    lo = vreinterpretq_u8_u16(vmlaq_u16(vreinterpretq_u16_u8(lo), vsubl_u8(vget_low_u8(in), vget_low_u8(out)), w));
    hi = vreinterpretq_u8_u16(vmlaq_u16(vreinterpretq_u16_u8(hi), vsubl_high_u8(in, out), w));
  }
  static Reg min16(Reg a, Reg b) {
    return vreinterpretq_u8_u16(vminq_u16(vreinterpretq_u16_u8(a), vreinterpretq_u16_u8(b)));
  }
  static int minimum(Reg v, int& lane) {
    const uint16x8_t w = vreinterpretq_u16_u8(v);
    const std::uint16_t least = vminvq_u16(w);
    const std::uint16_t ids[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    lane = vminvq_u16(vornq_u16(vld1q_u16(ids), vceqq_u16(w, vdupq_n_u16(least))));
    return least;
  }
};

void match_row(const MatchJob& job) { RowMatcher<Neon>(job).run(); }

}  // namespace

const Table kNeon{Isa::neon, kReference.remap_row, kReference.prefilter_row, match_row};

}  // namespace cliquevo::stereo::kernels
