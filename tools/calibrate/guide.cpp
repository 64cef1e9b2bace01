// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/guide.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/board_calibration/accuracy.h"
#include "drivers/board_calibration/start.h"

namespace cliquevo::tools {

namespace {

using calibration::LensModel;
using calibration::SeenCorner;
using calibration::Side;
using calibration::View;

constexpr double kMostBlur_px = 0.3;     // by motion during the exposure
constexpr double kMostSkewed_px = 0.1;   // by motion between the exposures
constexpr double kMostEdge_px = 9.0;     // of the width of edges, whatever the camera
constexpr double kMostOfSharp = 1.5;     // of the width of the sharpest fifth that was seen
constexpr std::size_t kEdgesKnown = 10;  // looks from which on that is known
constexpr double kAlike = 0.12;          // of a holding: less is no other view
constexpr int kNewCells = 3;             // with so many it is one in any case
constexpr double kFocalGuess = 0.9;      // of the width, before anything is known
constexpr double kTilted = 0.26;         // sine: 15 degrees
constexpr int kOfEachTilt = 2;
constexpr double kWantedCells = 0.65;     // of an image's
constexpr double kWantedShare = 0.42;     // of the width, from near
constexpr double kWantedDistances = 1.5;  // farthest over nearest
// What all parameters together may add to the drift, of the way: the odometry itself has 0.03 to 0.08 %.
constexpr double kWantedDrift_percent = 0.03;
constexpr std::size_t kLeastViews = 12;
constexpr int kMostPairs = 20;  // of one place: more make it no better
constexpr std::size_t kFirstEstimate = 8;
constexpr double kEstimateAgain = 1.3;  // times the views of the estimate before
constexpr std::size_t kManyViews = 40;  // from here on parts of the image may stay without corners,
constexpr std::size_t kVeryMany = 60;   // from here on precision may be missing

std::size_t cell_of(const Eigen::Vector2d& px, int width, int height) {
  const int x = std::clamp(static_cast<int>(kCellsAcross * px.x() / width), 0, kCellsAcross - 1);
  const int y = std::clamp(static_cast<int>(kCellsDown * px.y() / height), 0, kCellsDown - 1);
  return static_cast<std::size_t>(y) * kCellsAcross + static_cast<std::size_t>(x);
}

double filled(const Cells& cells) {
  return static_cast<double>(std::count(cells.begin(), cells.end(), true)) / static_cast<double>(cells.size());
}

// Views by the direction in which the board was tilted: right side away, left, lower, upper.
std::array<int, 4> tilts_of(const std::vector<Holding>& holdings) {
  std::array<int, 4> out{};
  for (const Holding& h : holdings) {
    out[0] += h.tilt.x() > kTilted ? 1 : 0;
    out[1] += h.tilt.x() < -kTilted ? 1 : 0;
    out[2] += h.tilt.y() > kTilted ? 1 : 0;
    out[3] += h.tilt.y() < -kTilted ? 1 : 0;
  }
  return out;
}

struct Range {
  double nearest_m = 1e9, farthest_m = 0.0, share = 0.0;
};
Range range_of(const std::vector<Holding>& holdings) {
  Range out;
  for (const Holding& h : holdings) {
    out.nearest_m = std::min(out.nearest_m, h.distance_m);
    out.farthest_m = std::max(out.farthest_m, h.distance_m);
    out.share = std::max(out.share, h.share);
  }
  return out;
}

}  // namespace

Guide::Guide(const calibration::Board& board, int width, int height, const GuideOptions& options)
    : board_(board), width_(width), height_(height), options_(options) {
  model_ = calibration::find_lens_model("radtan");
  for (auto& lens : lenses_) {
    lens.setZero();
    lens.head<4>() << kFocalGuess * width, kFocalGuess * width, 0.5 * (width - 1), 0.5 * (height - 1);
  }
}

Holding Guide::holding_of(const View& view) const {
  const Side side = view.left.empty() ? Side::right : Side::left;
  const std::vector<SeenCorner>& corners = view.of(side);
  const auto& lens = lenses_[static_cast<std::size_t>(side)];
  Holding out;
  Eigen::Vector2d low = corners[0].px, high = low;
  std::vector<Eigen::Vector3d> rays;
  for (const SeenCorner& c : corners) {
    low = low.cwiseMin(c.px);
    high = high.cwiseMax(c.px);
    out.centre += c.px.cwiseQuotient(Eigen::Vector2d(width_, height_)) / static_cast<double>(corners.size());
    rays.push_back(calibration::ideal_ray(*model_, lens, c.px));
  }
  out.share = std::max((high.x() - low.x()) / width_, (high.y() - low.y()) / height_);
  if (const auto pose = calibration::pose_from_rays(board_, corners, rays)) {
    // Of the face that looks at the camera.
    const Eigen::Vector3d away = pose->R.col(2).z() < 0.0 ? Eigen::Vector3d(-pose->R.col(2)) : pose->R.col(2);
    out.tilt = -away.head<2>();
    out.distance_m = pose->t.norm();
  }
  return out;
}

bool Guide::is_alike(const Holding& holding) const {
  return std::any_of(holdings_.begin(), holdings_.end(), [&](const Holding& other) {
    const double moved = (holding.centre - other.centre).norm() + std::abs(holding.share - other.share);
    return moved + 0.5 * (holding.tilt - other.tilt).norm() < kAlike;
  });
}

bool Guide::fills_cells(const View& view) const {
  std::array<Cells, 2> fresh = cells_;
  int added = 0;
  for (const Side side : {Side::left, Side::right}) {
    for (const SeenCorner& c : view.of(side)) {
      bool& cell = fresh[static_cast<std::size_t>(side)][cell_of(c.px, width_, height_)];
      added += cell ? 0 : 1;
      cell = true;
    }
  }
  return added >= kNewCells;
}

void Guide::fill(const View& view) {
  for (const Side side : {Side::left, Side::right}) {
    for (const SeenCorner& c : view.of(side)) {
      cells_[static_cast<std::size_t>(side)][cell_of(c.px, width_, height_)] = true;
    }
  }
}

Refusal Guide::judge(const Look& look) {
  const View& view = look.view;
  if (view.left.empty() && view.right.empty()) return Refusal::no_board;
  const double edge_px = std::max(look.edge_px[0], look.edge_px[1]);
  if (!look.speed_px_s || *look.speed_px_s * options_.exposure_s > kMostBlur_px) return Refusal::moving;
  if (*look.speed_px_s * std::abs(look.skew_s) > kMostSkewed_px) return Refusal::skewed;
  if (edge_px > kMostEdge_px) return Refusal::blurred;
  // One that stands still shows how sharp edges can be here.
  edges_.push_back(edge_px);
  if (edges_.size() >= kEdgesKnown) {
    std::vector<double> sorted = edges_;
    const auto fifth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 5);
    std::nth_element(sorted.begin(), fifth, sorted.end());
    if (edge_px > kMostOfSharp * *fifth) return Refusal::blurred;
  }
  const bool both = !view.left.empty() && !view.right.empty();
  if (fills_cells(view)) return Refusal::none;
  return both && !is_alike(holding_of(view)) ? Refusal::none : Refusal::alike;
}

void Guide::take(View view) {
  fill(view);
  holdings_.push_back(holding_of(view));
  last_ = HeldView(view);
  views_.push_back(std::move(view));
  if (views_.size() >=
      std::max(kFirstEstimate, static_cast<std::size_t>(kEstimateAgain * static_cast<double>(estimated_at_))))
    estimate_rig();
}

// What is refused for another reason than that it is known, is not sharp and still.
bool Guide::improves_last(const Look& look, Refusal refusal) const {
  return refusal == Refusal::alike && last_.pairs() < kMostPairs && last_.is_same_place(look.view);
}

void Guide::improve_last(const View& again) {
  last_.add(again);
  views_.back() = last_.mean();
}

void Guide::drop_last() {
  last_ = HeldView();
  if (views_.empty()) return;
  views_.pop_back();
  gather();
}

void Guide::gather() {
  holdings_.clear();
  for (Cells& cells : cells_) cells.fill(false);
  for (const View& view : views_) {
    holdings_.push_back(holding_of(view));
    fill(view);
  }
}

void Guide::estimate_rig() {
  estimated_at_ = views_.size();
  std::optional<calibration::Solution> best;
  const bool first = drift_percent_ == 0.0;
  for (const char* name : {"radtan", "equidistant"}) {
    if (!first && model_ != calibration::find_lens_model(name)) continue;
    calibration::SolveOptions options;
    options.model = name;
    options.held_out = false;
    auto solution = calibration::solve(board_, views_, width_, height_, options);
    if (!solution) continue;
    if (!best || solution->adjusted.sigma_px < best->adjusted.sigma_px) best = std::move(*solution);
  }
  if (!best) return;
  const calibration::Rig& rig = best->rig();
  model_ = rig.model;
  lenses_ = {rig.left, rig.right};
  drift_percent_ = calibration::accuracy(rig, best->adjusted.covariance).drift_percent;
  estimate_ = fmt::format("f {:.1f} px, baseline {:.1f} mm, corners to {:.3f} px, drift to {:.3f} % of the way",
                          rig.left(0), 1e3 * rig.T_right_left.t.norm(), best->adjusted.sigma_px, drift_percent_);
  gather();
}

std::array<Bar, 6> Guide::bars() const {
  const Range range = range_of(holdings_);
  const auto tilts = tilts_of(holdings_);
  double tilted = 0.0;
  for (const int n : tilts) tilted += 0.25 * std::min(n, kOfEachTilt) / kOfEachTilt;
  const double distances = holdings_.empty() ? 0.0 : range.farthest_m / std::max(1e-6, range.nearest_m);
  const auto part = [](double share) { return std::clamp(share, 0.0, 1.0); };
  return {{{"image left", part(filled(cells_[0]) / kWantedCells)},
           {"image right", part(filled(cells_[1]) / kWantedCells)},
           {"scale", part(range.share / kWantedShare)},
           {"tilt", tilted},
           {"distance", part((distances - 1.0) / (kWantedDistances - 1.0))},
           {"precision", drift_percent_ > 0.0 ? part(kWantedDrift_percent / drift_percent_) : 0.0}}};
}

bool Guide::enough() const {
  if (views_.size() >= options_.most_views) return true;
  const auto all = bars();
  const auto full = [&](std::ptrdiff_t first, std::ptrdiff_t last) {
    return std::all_of(all.begin() + first, all.begin() + last, [](const Bar& bar) { return bar.share >= 1.0; });
  };
  if (views_.size() < kLeastViews || !full(2, 5)) return false;
  const bool images = views_.size() >= kManyViews || full(0, 2);
  const bool precision = views_.size() >= kVeryMany || full(5, 6);
  return images && precision;
}

// The ninth of the images with the fewest corners.
std::string Guide::missing_place() const {
  static constexpr std::array<const char*, 3> kDown{"upper", "middle", "lower"};
  static constexpr std::array<const char*, 3> kAcross{"left", "middle", "right"};
  double least = 2.0;
  std::string out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      double seen = 0.0, all = 0.0;
      for (const Cells& cells : cells_) {
        for (int k = 0; k < kCellsAcross * kCellsDown; ++k) {
          if (k % kCellsAcross * 3 / kCellsAcross != column || k / kCellsAcross * 3 / kCellsDown != row) continue;
          seen += cells[static_cast<std::size_t>(k)] ? 1.0 : 0.0;
          all += 1.0;
        }
      }
      if (seen / all >= least) continue;
      least = seen / all;
      const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
      out = row == 1 ? kAcross[c] : column == 1 ? kDown[r] : fmt::format("{} {}", kDown[r], kAcross[c]);
    }
  }
  return out;
}

std::string Guide::next() const {
  const auto all = bars();
  std::vector<std::string> parts;
  if (std::min(all[0].share, all[1].share) < 1.0) parts.push_back(missing_place());
  if (all[2].share < 1.0) {
    parts.emplace_back("closer");
  } else if (all[4].share < 1.0) {
    parts.emplace_back("farther away");
  }
  if (all[3].share < 1.0) {
    static constexpr std::array<const char*, 4> kTilts{"tilt its right side away", "tilt its left side away",
                                                       "tilt its lower side away", "tilt its upper side away"};
    const auto tilts = tilts_of(holdings_);
    parts.emplace_back(kTilts[static_cast<std::size_t>(std::min_element(tilts.begin(), tilts.end()) - tilts.begin())]);
  }
  if (parts.empty() && !enough()) parts.emplace_back("more views, each in another place and tilt");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string Guide::advice(const Look& look, Refusal refusal) const {
  if (enough()) return "enough";
  const std::string wanted = next();
  switch (refusal) {
    case Refusal::no_board:
      return "the board is not seen; next: " + wanted;
    case Refusal::moving:
      return "hold it still; next: " + wanted;
    case Refusal::skewed:
      return fmt::format("hold it still: the cameras expose {:.1f} ms apart", 1e3 * std::abs(look.skew_s));
    case Refusal::blurred:
      return "blurred: hold it still, with more light, in focus";
    case Refusal::none:
    case Refusal::alike:
      break;
  }
  const bool left = !look.view.left.empty(), right = !look.view.right.empty();
  if (!left || !right) return fmt::format("only the {} camera sees it; next: {}", left ? "left" : "right", wanted);
  return "next: " + wanted;
}

}  // namespace cliquevo::tools
