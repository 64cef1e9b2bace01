// SPDX-License-Identifier: BSD-3-Clause
// Which pixels a thing in space can touch.
#pragma once

#include <algorithm>
#include <cmath>

#include "drivers/simulator/raster.h"

namespace cliquevo::drivers::sim {

inline constexpr double kNearM = 0.12;

struct Rectangle {
  int i0, i1, j0, j1;  // i1, j1 excluded
  bool empty() const { return i0 >= i1 || j0 >= j1; }
};

// Image rectangle around points given in camera coordinates; the whole image when one of them is behind it.
inline Rectangle around(const View& view, const Eigen::Vector3d* points, int count) {
  double u0 = 1e9;
  double u1 = -1e9;
  double v0 = 1e9;
  double v1 = -1e9;
  int behind = 0;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d& p = points[k];
    if (p.z() < kNearM) {
      ++behind;
      continue;
    }
    const double u = p.x() / p.z() * view.focal_px + view.cx_px - view.offset_x;
    const double v = p.y() / p.z() * view.focal_px + view.cy_px - view.offset_y;
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
  if (behind == count) return {0, 0, 0, 0};
  if (behind > 0) return {0, view.width, 0, view.height};
  const auto pixel = [](double v, int size) {
    return static_cast<int>(std::clamp(std::ceil(v), 0.0, static_cast<double>(size)));
  };
  return {pixel(u0, view.width), pixel(u1 + 1e-6, view.width), pixel(v0, view.height), pixel(v1 + 1e-6, view.height)};
}

}  // namespace cliquevo::drivers::sim
