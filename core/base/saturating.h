// SPDX-License-Identifier: BSD-3-Clause
// Sums of numbers that a damaged file may hold: at the end of the range they stay there.
#pragma once

#include <cstdint>
#include <limits>

namespace cliquevo {

constexpr std::int64_t saturated_sum(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return b < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}

// How far apart, >= 0.
constexpr std::int64_t saturated_distance(std::int64_t a, std::int64_t b) {
  std::int64_t distance = 0;
  const bool beyond = a < b ? __builtin_sub_overflow(b, a, &distance) : __builtin_sub_overflow(a, b, &distance);
  return beyond ? std::numeric_limits<std::int64_t>::max() : distance;
}

}  // namespace cliquevo
