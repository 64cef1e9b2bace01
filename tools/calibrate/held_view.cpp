// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/held_view.h"

#include "tools/calibrate/moved.h"

namespace cliquevo::tools {

namespace {

using calibration::SeenCorner;
using calibration::Side;
using calibration::View;

// Mean way of the corners. A pixel's way bends the image of a place by its square over the focal length: nothing.
constexpr double kSamePlace_px = 1.0;
constexpr double kMostMissing = 0.1;  // of the corners, which would be lost to the mean

}  // namespace

HeldView::HeldView(const View& first) : first_(first), pairs_(1) {
  for (const Side side : {Side::left, Side::right}) {
    for (const SeenCorner& c : first.of(side)) sums_[static_cast<std::size_t>(side)][c.id] = c.px;
  }
}

bool HeldView::is_same_place(const View& again) const {
  if (pairs_ == 0) return false;
  for (const Side side : {Side::left, Side::right}) {
    const auto& sums = sums_[static_cast<std::size_t>(side)];
    if (sums.empty()) continue;
    const auto moved = moved_px(first_.of(side), again.of(side));
    if (!moved || *moved > kSamePlace_px) return false;
    double shared = 0.0;
    for (const SeenCorner& c : again.of(side)) shared += sums.contains(c.id) ? 1.0 : 0.0;
    if (shared < (1.0 - kMostMissing) * static_cast<double>(sums.size())) return false;
  }
  return true;
}

void HeldView::add(const View& again) {
  for (const Side side : {Side::left, Side::right}) {
    auto& sums = sums_[static_cast<std::size_t>(side)];
    std::map<int, Eigen::Vector2d> both;
    for (const SeenCorner& c : again.of(side)) {
      if (const auto at = sums.find(c.id); at != sums.end()) both[c.id] = at->second + c.px;
    }
    sums = std::move(both);
  }
  ++pairs_;
}

View HeldView::mean() const {
  View out{first_.name, {}, {}};
  for (const Side side : {Side::left, Side::right}) {
    for (const auto& [id, sum] : sums_[static_cast<std::size_t>(side)]) {
      out.of(side).push_back({id, sum / static_cast<double>(pairs_)});
    }
  }
  return out;
}

}  // namespace cliquevo::tools
