// SPDX-License-Identifier: BSD-3-Clause
#include <arm_neon.h>

#include "core/vo/kernels/fast_circle.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"
#include "core/vo/kernels/tables.h"

namespace cliquevo::vo {
namespace {

int fast_row(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::int16_t* columns,
             std::uint8_t* scores) {
  std::ptrdiff_t offsets[16];
  circle_offsets(stride, offsets);
  const uint8x16_t t = vdupq_n_u8(static_cast<std::uint8_t>(threshold));
  const uint8x16_t one = vdupq_n_u8(1);
  int n = 0;
  if (x1 - x0 < 16) return kReferenceKernels.fast_row(row, stride, x0, x1, threshold, columns, scores);
  for (int next = x0; next < x1; next += 16) {
    const int x = next + 16 <= x1 ? next : x1 - 16;  // the last pack overlaps the one before
    const std::uint8_t* p = row + x;
    const uint8x16_t c = vld1q_u8(p);
    const uint8x16_t above = vqaddq_u8(c, t);
    const uint8x16_t below = vqsubq_u8(c, t);
    const auto brighter = [&](int i) { return vcgtq_u8(vld1q_u8(p + offsets[i]), above); };
    const auto darker = [&](int i) { return vcltq_u8(vld1q_u8(p + offsets[i]), below); };
    // Nine contiguous pixels hold at least one of each opposite pair: reject by the four on the axes first.
    const uint8x16_t vertical = vorrq_u8(vorrq_u8(brighter(0), brighter(8)), vorrq_u8(darker(0), darker(8)));
    const uint8x16_t across = vorrq_u8(vorrq_u8(brighter(4), brighter(12)), vorrq_u8(darker(4), darker(12)));
    if (vmaxvq_u8(vandq_u8(vertical, across)) == 0) continue;
    uint8x16_t run_b = vdupq_n_u8(0);
    uint8x16_t run_d = vdupq_n_u8(0);
    uint8x16_t longest = vdupq_n_u8(0);
    for (int k = 0; k < 24; ++k) {
      run_b = vandq_u8(brighter(k & 15), vaddq_u8(run_b, one));
      run_d = vandq_u8(darker(k & 15), vaddq_u8(run_d, one));
      longest = vmaxq_u8(longest, vmaxq_u8(run_b, run_d));
    }
    std::uint8_t runs[16];
    vst1q_u8(runs, longest);
    for (int i = next - x; i < 16; ++i) {
      if (runs[i] < 9) continue;
      columns[n] = static_cast<std::int16_t>(x + i);
      scores[n++] = static_cast<std::uint8_t>(fast_score(p + i, offsets));
    }
  }
  return n;
}

void sad_row(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length, std::uint16_t* scores) {
  const int blocks = (length + 15) / 16;
  for (int j = 0; j < count; ++j) {
    const std::uint8_t* other = others + static_cast<std::ptrdiff_t>(j) * kDescriptorStride;
    std::uint32_t sum = 0;
    for (int k = 0; k < blocks; ++k) {
      sum += vaddlvq_u8(vabdq_u8(vld1q_u8(descriptor + 16 * k), vld1q_u8(other + 16 * k)));
    }
    scores[j] = static_cast<std::uint16_t>(sum);
  }
}

}  // namespace

const Kernels kNeonKernels = {fast_row, sad_row, patch_sample_plain, patch_sums_of<VectorFloats>,
                              motion_sums_of<VectorPack>};

}  // namespace cliquevo::vo
