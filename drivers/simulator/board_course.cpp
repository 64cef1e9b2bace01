// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/board_course.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

// Angle of the board's width, of the field of view: held near and far.
constexpr std::array<double, 4> kShares{0.55, 0.35, 0.75, 0.45};
constexpr double kMostView_rad = 2.4;
constexpr double kMostTilt_rad = 0.8;
constexpr double kMostRoll_rad = 0.3;
constexpr double kTurnOfTilt_rad = 2.399963;  // golden angle: every direction in turn
constexpr double kInPart = 0.6;               // of the outline: enough of a board with markers
constexpr int kOneCameraEvery = 4;            // every so many places need one camera alone, in turn
constexpr int kTries = 60;
constexpr std::size_t kRemembered = 16;  // places

// Radical inverse: places that fill an interval evenly.
double spread(std::int64_t index, int base) {
  double out = 0.0;
  double digit = 1.0 / base;
  for (; index > 0; index /= base, digit /= base) out += digit * static_cast<double>(index % base);
  return out;
}

}  // namespace

BoardCourse::BoardCourse(const SimulatorOptions& o, const BoardPattern& pattern, const StereoCalibration& rig)
    : pattern_(pattern), left_(rig.left), right_(rig.right), T_right_left_(rig.T_right_left), seed_(o.rig_seed) {
  const auto a = left_.direction(0.0, rig.left.cy_px), b = left_.direction(rig.left.width - 1.0, rig.left.cy_px);
  if (a && b) view_rad_ = std::min(std::acos(std::clamp(a->dot(*b), -1.0, 1.0)), kMostView_rad);
  const auto kind = pattern.board().kind;
  whole_ = kind == calibration::BoardKind::chessboard || kind == calibration::BoardKind::circles;
  // Without a time to hold it, every frame is a place of its own.
  hold_s_ = o.board_hold_s;
  move_s_ = o.board_hold_s > 0.0 ? o.board_move_s : 0.0;
  period_s_ = o.board_hold_s > 0.0 ? hold_s_ + move_s_ : 1.0 / o.rate_hz;
  middle_ << pattern.middle(), 0.0;
}

std::optional<RigidTransform> BoardCourse::choose(std::int64_t k) const {
  Random random(hash_cell(mix64(seed_ ^ 0x706c616365ULL), k, 0));
  const double tilt = k % 5 == 0 ? 0.0 : kMostTilt_rad * random.uniform(0.4, 1.0);
  const double roll = random.uniform(-kMostRoll_rad, kMostRoll_rad);
  const double share = kShares[static_cast<std::size_t>(k) % kShares.size()];
  double far_m = 0.5 * pattern_.width_m() / std::tan(0.5 * share * view_rad_);
  Eigen::Vector2d from_centre(spread(k + 1, 2) - 0.5, spread(k + 1, 3) - 0.5);
  for (int i = 0; i < kTries; ++i) {
    const Eigen::Vector2d px(0.5 * (left_.camera().width - 1) + from_centre.x() * left_.camera().width,
                             0.5 * (left_.camera().height - 1) + from_centre.y() * left_.camera().height);
    if (const auto direction = left_.direction(px.x(), px.y())) {
      const RigidTransform T = held(*direction, far_m, tilt, kTurnOfTilt_rad * static_cast<double>(k % 1000), roll);
      if (is_seen(T, k)) return T;
    }
    // Nearer to the middle, now and then farther away.
    from_centre *= 0.88;
    if (i % 6 == 5) far_m *= 1.15;
  }
  return std::nullopt;
}

RigidTransform BoardCourse::held(const Eigen::Vector3d& direction, double far_m, double tilt, double tilt_to,
                                 double roll) const {
  RigidTransform T;
  T.R.col(2) = direction;
  T.R.col(0) = Eigen::Vector3d::UnitY().cross(direction).normalized();
  T.R.col(1) = T.R.col(2).cross(T.R.col(0));
  T.R = T.R * so3_exp(tilt * Eigen::Vector3d(std::cos(tilt_to), std::sin(tilt_to), 0.0)) * so3_exp({0.0, 0.0, roll});
  // The board's y is up, as its maker has it.
  if (pattern_.board().kind == calibration::BoardKind::aprilgrid) {
    T.R = T.R * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  }
  T.t = far_m * direction - T.R.leftCols<2>() * pattern_.middle();
  return T;
}

bool BoardCourse::shown(const SimulatedLens& lens, const RigidTransform& T) const {
  const std::vector<Eigen::Vector3d> outline = pattern_.outline();
  const auto seen = std::count_if(outline.begin(), outline.end(), [&](const auto& p) { return lens.shows(T * p); });
  const auto all = static_cast<double>(outline.size());
  return static_cast<double>(seen) >= (whole_ ? all : kInPart * all);
}

bool BoardCourse::is_seen(const RigidTransform& T, std::int64_t k) const {
  const bool left = shown(left_, T), right = shown(right_, T_right_left_ * T);
  if (k % kOneCameraEvery != kOneCameraEvery - 1) return left && right;
  return k / kOneCameraEvery % 2 == 0 ? left : right;
}

Result<BoardCourse> BoardCourse::make(const SimulatorOptions& o, const BoardPattern& pattern,
                                      const StereoCalibration& rig) {
  BoardCourse out(o, pattern, rig);
  const auto first = out.choose(0);
  if (!first) {
    return Error{"bad simulator option", "board = " + pattern.board().text(),
                 "it cannot be held where both cameras see it: use a larger one, or a smaller baseline_m"};
  }
  out.places_[0] = *first;
  return out;
}

const RigidTransform& BoardCourse::place(std::int64_t k) const {
  if (const auto known = places_.find(k); known != places_.end()) return known->second;
  while (places_.size() > kRemembered) places_.erase(std::next(places_.begin()));  // the first stays
  return places_[k] = choose(k).value_or(places_.at(0));
}

RigidTransform BoardCourse::T_left_board(double time_s) const {
  const double t = std::max(time_s, 0.0) + (hold_s_ > 0.0 ? 0.5 * hold_s_ : 0.5 * period_s_);
  const auto k = static_cast<std::int64_t>(t / period_s_);
  const double since_s = t - static_cast<double>(k) * period_s_;
  if (hold_s_ <= 0.0 || since_s <= hold_s_ || move_s_ <= 0.0) return place(k);
  const double x = std::min((since_s - hold_s_) / move_s_, 1.0);
  const double share = x * x * (3.0 - 2.0 * x);
  const RigidTransform a = place(k), b = place(k + 1);
  RigidTransform T;
  T.R = a.R * so3_exp(share * so3_log(a.R.transpose() * b.R));
  T.t = (1.0 - share) * (a * middle_) + share * (b * middle_) - T.R * middle_;
  return T;
}

}  // namespace cliquevo::drivers::sim
