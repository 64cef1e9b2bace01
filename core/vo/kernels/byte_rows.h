// SPDX-License-Identifier: BSD-3-Clause
// FAST, and the rows of the score matrix with their minima, written once over the few operations `V` that each
// instruction set supplies. Internal linkage on purpose: each kernel file is compiled with other machine options.
#pragma once

#include "core/vo/kernels/fast_circle.h"
#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {
namespace {

// Over all nine neighbours on the circle: the largest of their least values, or with the two exchanged the least of
// their largest. Two such arcs share eight of their nine.
template <class Reg, class Less, class More>
inline Reg best_arc(const Reg (&m)[16], Less&& less, More&& more) {
  Reg two[8];
  Reg four[8];
  for (int i = 0; i < 8; ++i) two[i] = less(m[2 * i + 1], m[(2 * i + 2) & 15]);
  for (int i = 0; i < 8; ++i) four[i] = less(two[i], two[(i + 1) & 7]);
  Reg best;
  for (int i = 0; i < 8; ++i) {
    const Reg nine = less(less(four[i], four[(i + 2) & 7]), more(m[2 * i], m[(2 * i + 9) & 15]));
    best = i == 0 ? nine : more(best, nine);
  }
  return best;
}

template <class V>
void fast_row_of(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::uint8_t* scores) {
  using Reg = typename V::Reg;
  constexpr int kBytes = V::kBytes;
  if (x1 - x0 < kBytes) return kReferenceKernels.fast_row(row, stride, x0, x1, threshold, scores);
  std::ptrdiff_t offsets[16];
  circle_offsets(stride, offsets);
  const Reg t = V::broadcast8(threshold);
  const Reg one = V::broadcast8(1);
  const auto least = [](Reg a, Reg b) { return V::min8(a, b); };
  const auto most = [](Reg a, Reg b) { return V::max8(a, b); };
  for (int next = x0; next < x1; next += kBytes) {
    const int x = next + kBytes <= x1 ? next : x1 - kBytes;  // the last pack overlaps the one before
    const std::uint8_t* p = row + x;
    const Reg c = V::load(p);
    Reg circle[16];
    // Nine contiguous pixels hold at least one of each opposite pair: reject by those on the axes first, then by the
    // diagonal ones. At most so bright, and at least so dark, is an arc.
    const auto brightest = [&](int i) {
      return V::min8(V::max8(circle[i], circle[i + 8]), V::max8(circle[i + 4], circle[(i + 12) & 15]));
    };
    const auto darkest = [&](int i) {
      return V::max8(V::min8(circle[i], circle[i + 8]), V::min8(circle[i + 4], circle[(i + 12) & 15]));
    };
    for (int i = 0; i < 16; i += 4) circle[i] = V::load(p + offsets[i]);
    Reg bright = brightest(0);
    Reg dark = darkest(0);
    V::store(scores + x, V::zero());
    if (!V::any_above(V::max8(V::subtract_saturated(bright, c), V::subtract_saturated(c, dark)), t)) continue;
    for (int i = 2; i < 16; i += 4) circle[i] = V::load(p + offsets[i]);
    bright = V::min8(bright, brightest(2));
    dark = V::max8(dark, darkest(2));
    const Reg brighter = V::subtract_saturated(bright, c);
    const Reg darker = V::subtract_saturated(c, dark);
    const bool any_brighter = V::any_above(brighter, t);
    const bool any_darker = V::any_above(darker, t);
    if (!any_brighter && !any_darker) continue;
    for (int i = 1; i < 16; i += 2) circle[i] = V::load(p + offsets[i]);
    Reg best = V::zero();
    if (any_brighter) best = V::subtract_saturated(best_arc(circle, least, most), c);
    if (any_darker) best = V::max8(best, V::subtract_saturated(c, best_arc(circle, most, least)));
    const Reg below = V::equal8(V::subtract_saturated(best, t), V::zero());
    V::store(scores + x, V::select(below, V::zero(), V::subtract_saturated(best, one)));
  }
}

template <class V>
int maxima_row_of(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int x0, int x1,
                  std::int16_t* columns) {
  using Reg = typename V::Reg;
  constexpr int kBytes = V::kBytes;
  if (x1 - x0 < kBytes) return kReferenceKernels.maxima_row(above, row, below, x0, x1, columns);
  int n = 0;
  for (int next = x0; next < x1; next += kBytes) {
    const int x = next + kBytes <= x1 ? next : x1 - kBytes;
    const Reg s = V::load(row + x);
    if (!V::any_above(s, V::zero())) continue;
    const Reg before = V::max8(V::max8(V::load(above + x - 1), V::load(above + x)),
                               V::max8(V::load(above + x + 1), V::load(row + x - 1)));
    const Reg after = V::max8(V::max8(V::load(below + x - 1), V::load(below + x)),
                              V::max8(V::load(below + x + 1), V::load(row + x + 1)));
    // s > before and s >= after
    const Reg beaten = V::equal8(V::subtract_saturated(s, before), V::zero());
    const Reg wins = V::select(beaten, V::zero(), V::equal8(V::max8(s, after), s));
    std::uint64_t bits = V::bits(wins) >> (V::kBitsPerByte * (next - x));
    constexpr std::uint64_t kByte = (std::uint64_t{1} << V::kBitsPerByte) - 1;
    while (bits != 0) {
      const int place = __builtin_ctzll(bits);
      columns[n++] = static_cast<std::int16_t>(next + place / V::kBitsPerByte);
      bits &= ~(kByte << place);
    }
  }
  return n;
}

template <class V, int kBlocks>
void sad_row_in_blocks(const std::uint8_t* descriptor, const std::uint8_t* others, int count, std::uint16_t* scores) {
  using Reg = typename V::Reg;
  Reg mine[kBlocks];
  for (int k = 0; k < kBlocks; ++k) mine[k] = V::load(descriptor + k * V::kBytes);
  const auto sums = [&mine](const std::uint8_t* other) {
    Reg sum = V::sad(mine[0], V::load(other));
    for (int k = 1; k < kBlocks; ++k) sum = V::add64(sum, V::sad(mine[k], V::load(other + k * V::kBytes)));
    return sum;
  };
  int j = 0;
  for (; j + 4 <= count; j += 4, others += static_cast<std::ptrdiff_t>(4) * kDescriptorStride) {
    V::store_four(scores + j, sums(others), sums(others + kDescriptorStride), sums(others + 2 * kDescriptorStride),
                  sums(others + static_cast<std::ptrdiff_t>(3) * kDescriptorStride));
  }
  for (; j < count; ++j, others += kDescriptorStride) {
    std::uint16_t four[4];
    const Reg sum = sums(others);
    V::store_four(four, sum, sum, sum, sum);
    scores[j] = four[0];
  }
}

template <class V>
void sad_row_of(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length,
                std::uint16_t* scores) {
  constexpr int kMost = kDescriptorStride / V::kBytes;
  const int blocks = (length + V::kBytes - 1) / V::kBytes;
  if constexpr (V::kBytes <= 32) {
    if (blocks * V::kBytes <= 32) return sad_row_in_blocks<V, 32 / V::kBytes>(descriptor, others, count, scores);
    if (blocks * V::kBytes <= 48)
      return sad_row_in_blocks<V, (48 + V::kBytes - 1) / V::kBytes>(descriptor, others, count, scores);
  }
  if (blocks * V::kBytes <= 64) return sad_row_in_blocks<V, 64 / V::kBytes>(descriptor, others, count, scores);
  sad_row_in_blocks<V, kMost>(descriptor, others, count, scores);
}

template <class V>
int row_minimum_of(const std::uint16_t* scores, int count, int row, std::uint16_t* column_score,
                   std::int16_t* column_best) {
  using Reg = typename V::Reg;
  constexpr int kWords = V::kBytes / 2;
  const Reg mine = V::broadcast16(row);
  Reg least = V::broadcast16(0xFFFF);
  int j = 0;
  for (; j + kWords <= count; j += kWords) {
    const Reg s = V::load(scores + j);
    const Reg before = V::load(column_score + j);
    const Reg now = V::min16(s, before);
    const Reg kept = V::equal16(now, before);
    V::store(column_score + j, now);
    V::store(column_best + j, V::select(kept, V::load(column_best + j), mine));
    least = V::min16(least, s);
  }
  std::uint16_t lanes[kWords];
  V::store(lanes, least);
  std::uint16_t lowest = 0xFFFF;
  for (const std::uint16_t v : lanes) lowest = v < lowest ? v : lowest;
  for (; j < count; ++j) {
    lowest = scores[j] < lowest ? scores[j] : lowest;
    if (scores[j] < column_score[j]) {
      column_score[j] = scores[j];
      column_best[j] = static_cast<std::int16_t>(row);
    }
  }
  int first = 0;
  const Reg wanted = V::broadcast16(lowest);
  while (first + kWords <= count && !V::any(V::equal16(V::load(scores + first), wanted))) first += kWords;
  while (first < count && scores[first] != lowest) ++first;
  return first;
}

}  // namespace
}  // namespace cliquevo::vo
