// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/moved.h"

#include <algorithm>
#include <map>

namespace cliquevo::tools {

using calibration::SeenCorner;

std::optional<double> moved_px(const std::vector<SeenCorner>& a, const std::vector<SeenCorner>& b) {
  std::map<int, Eigen::Vector2d> places;
  for (const SeenCorner& c : a) places[c.id] = c.px;
  double sum = 0.0;
  double shared = 0.0;
  for (const SeenCorner& c : b) {
    const auto at = places.find(c.id);
    if (at == places.end()) continue;
    sum += (c.px - at->second).norm();
    shared += 1.0;
  }
  if (shared < 0.5 * static_cast<double>(std::max(a.size(), b.size())) || shared < 1.0) return std::nullopt;
  return sum / shared;
}

}  // namespace cliquevo::tools
