// SPDX-License-Identifier: BSD-3-Clause
// Gradient noise (Perlin 2002: quintic fade, so twice differentiable) in two and three dimensions.
#pragma once

#include <cmath>
#include <cstdint>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

// Unit lattice, zero at the lattice points, about -0.7 to 0.7; standard deviation about 0.25.
inline double gradient_noise(std::uint64_t seed, double x, double y) {
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  const auto ix = static_cast<std::int64_t>(fx);
  const auto iy = static_cast<std::int64_t>(fy);
  const double dx = x - fx;
  const double dy = y - fy;
  const auto corner = [&](std::int64_t cx, std::int64_t cy, double px, double py) {
    const std::uint64_t h = hash_cell(seed, cx, cy);
    const double gx = static_cast<double>(h & 0xffffff) * (2.0 / 16777215.0) - 1.0;
    const double gy = static_cast<double>((h >> 24) & 0xffffff) * (2.0 / 16777215.0) - 1.0;
    return gx * px + gy * py;
  };
  const auto fade = [](double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); };
  const double u = fade(dx);
  const double v = fade(dy);
  const double a = corner(ix, iy, dx, dy);
  const double b = corner(ix + 1, iy, dx - 1.0, dy);
  const double c = corner(ix, iy + 1, dx, dy - 1.0);
  const double d = corner(ix + 1, iy + 1, dx - 1.0, dy - 1.0);
  const double top = a + u * (b - a);
  const double bottom = c + u * (d - c);
  return top + v * (bottom - top);
}

}  // namespace cliquevo::drivers::sim
