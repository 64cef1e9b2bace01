// SPDX-License-Identifier: BSD-3-Clause
// The smooth height of the ground: rolling hills down to bumps of a few metres. The rendered surface is its sampling on
// a fixed grid (see world.h), the vehicle rides on the smooth function.
#pragma once

#include <cstdint>

namespace cliquevo::drivers::sim {

class Terrain {
 public:
  explicit Terrain(std::uint64_t seed) : seed_(seed) {}
  // Metres; twice differentiable.
  double height(double x, double y) const;

 private:
  std::uint64_t seed_;
};

}  // namespace cliquevo::drivers::sim
