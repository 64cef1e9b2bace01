// SPDX-License-Identifier: BSD-3-Clause
// Deterministic pseudo-random numbers: what is random in the world is a hash of where it is, so that no order of
// evaluation can change it.
#pragma once

#include <cstdint>

namespace cliquevo::drivers::sim {

// splitmix64 finaliser (Steele, Lea, Flood 2014).
inline std::uint64_t mix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

inline std::uint64_t hash_cell(std::uint64_t seed, std::int64_t x, std::int64_t y) {
  return mix64(mix64(seed ^ (static_cast<std::uint64_t>(x) * 0x8da6b343ULL)) ^ static_cast<std::uint64_t>(y));
}

// [0, 1)
inline double to_unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() { return mix64(state_++); }
  double uniform() { return to_unit(bits()); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

 private:
  std::uint64_t state_;
};

}  // namespace cliquevo::drivers::sim
