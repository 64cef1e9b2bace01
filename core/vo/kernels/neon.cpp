// SPDX-License-Identifier: BSD-3-Clause
#include <arm_neon.h>

#include "core/vo/kernels/byte_rows.h"
#include "core/vo/kernels/graph_rows.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"

namespace cliquevo::vo {
namespace {

struct NeonBytes {
  using Reg = uint8x16_t;
  static constexpr int kBytes = 16;
  static uint16x8_t words(Reg v) { return vreinterpretq_u16_u8(v); }
  static Reg bytes(uint16x8_t v) { return vreinterpretq_u8_u16(v); }
  static Reg zero() { return vdupq_n_u8(0); }
  static Reg load(const void* p) { return vld1q_u8(static_cast<const std::uint8_t*>(p)); }
  static void store(void* p, Reg v) { vst1q_u8(static_cast<std::uint8_t*>(p), v); }
  static Reg broadcast8(int v) { return vdupq_n_u8(static_cast<std::uint8_t>(v)); }
  static Reg broadcast16(int v) { return bytes(vdupq_n_u16(static_cast<std::uint16_t>(v))); }
  static Reg min8(Reg a, Reg b) { return vminq_u8(a, b); }
  static Reg max8(Reg a, Reg b) { return vmaxq_u8(a, b); }
  static Reg min16(Reg a, Reg b) { return bytes(vminq_u16(words(a), words(b))); }
  static Reg equal16(Reg a, Reg b) { return bytes(vceqq_u16(words(a), words(b))); }
  static Reg select(Reg mask, Reg a, Reg b) { return vbslq_u8(mask, a, b); }
  static Reg subtract_saturated(Reg a, Reg b) { return vqsubq_u8(a, b); }
  static Reg equal8(Reg a, Reg b) { return vceqq_u8(a, b); }
  static constexpr int kBitsPerByte = 4;
  static std::uint64_t bits(Reg mask) { return vget_lane_u64(vreinterpret_u64_u8(vshrn_n_u16(words(mask), 4)), 0); }
  static bool any(Reg mask) { return vmaxvq_u8(mask) != 0; }
  static bool any_above(Reg a, Reg b) { return vmaxvq_u8(vqsubq_u8(a, b)) != 0; }
  // Sums of pairs, in 16 bits.
  static Reg sad(Reg a, Reg b) { return bytes(vpaddlq_u8(vabdq_u8(a, b))); }
  static Reg add64(Reg a, Reg b) { return bytes(vaddq_u16(words(a), words(b))); }
  static void store_four(std::uint16_t* to, Reg a, Reg b, Reg c, Reg d) {
    const uint16x8_t ab = vpaddq_u16(words(a), words(b));
    const uint16x8_t cd = vpaddq_u16(words(c), words(d));
    const uint16x8_t all = vpaddq_u16(ab, cd);
    vst1_u16(to, vget_low_u16(vpaddq_u16(all, all)));
  }
};

}  // namespace

void use_neon(Kernels& table) {
  table.fast_row = fast_row_of<NeonBytes>;
  table.maxima_row = maxima_row_of<NeonBytes>;
  table.sad_row = sad_row_of<NeonBytes>;
  table.row_minimum = row_minimum_of<NeonBytes>;
  table.graph_row = graph_row_of<VectorFloats>;
  table.patch_cut = patch_cut_of<VectorFloats>;
  table.patch_sums = patch_sums_of<VectorFloats, true>;
  table.patch_sums_across = patch_sums_of<VectorFloats, false>;
  table.motion_sums = motion_sums_of<VectorPack>;
}

}  // namespace cliquevo::vo
