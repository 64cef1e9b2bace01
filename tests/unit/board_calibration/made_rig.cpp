// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/board_calibration/made_rig.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace cliquevo::calibration {

namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kRadian = M_PI / 180.0;

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(bits_() >> 11U) * 0x1.0p-53;
  }
  double normal() {  // Box and Muller: the same everywhere
    const double u = std::max(1e-300, uniform(0.0, 1.0));
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * M_PI * uniform(0.0, 1.0));
  }
  Eigen::Vector3d vector() {
    const double x = uniform(-1.0, 1.0), y = uniform(-1.0, 1.0), z = uniform(-1.0, 1.0);
    return {x, y, z};
  }

 private:
  std::mt19937_64 bits_;
};

void make_lens(Random& random, bool fisheye, double view_deg, LensVector& lens) {
  const double half = 0.5 * view_deg * kRadian;
  const double f = 0.5 * kWidth / (fisheye ? half : std::tan(half));
  for (const int i : {0, 1}) lens(i) = f * random.uniform(0.99, 1.01);
  lens(2) = 0.5 * (kWidth - 1) + random.uniform(-10.0, 10.0);
  lens(3) = 0.5 * (kHeight - 1) + random.uniform(-10.0, 10.0);
  const double strength = fisheye ? 0.02 : view_deg > 80.0 ? 0.05 : 0.2;
  lens(4) = random.uniform(-strength, 0.2 * strength);
  lens(5) = 0.2 * random.uniform(-strength, strength);
  if (fisheye) return;
  for (const int i : {6, 7}) lens(i) = random.uniform(-5e-4, 5e-4);
}

bool inside(const Eigen::Vector2d& px) {
  return px.x() > 2.0 && px.y() > 2.0 && px.x() < kWidth - 3.0 && px.y() < kHeight - 3.0;
}

View look(const Rig& rig, const Board& board, const RigidTransform& T_left_board) {
  View view;
  for (const Side side : {Side::left, Side::right}) {
    for (int id = 0; id < board.corner_count(); ++id) {
      Eigen::Vector3d p = T_left_board * board.corner(id);
      if (side == Side::right) p = rig.T_right_left * p;
      if (rig.model->distortion != Distortion::equidistant && p.z() < 0.2 * p.norm()) continue;
      const Projection seen = project_with_derivatives(*rig.model, rig.lens(side), p);
      if (seen.seen && inside(seen.px)) view.of(side).push_back({id, seen.px});
    }
  }
  return view;
}

}  // namespace

MadeRig make_rig(std::uint64_t seed, int views, double noise_px) {
  Random random(77 + seed);
  const bool fisheye = seed % 4 == 3;
  MadeRig out;
  Rig& rig = out.rig;
  rig.model = find_lens_model(fisheye ? "equidistant" : seed % 4 == 2 ? "plumb_bob" : "radtan");
  rig.width = kWidth;
  rig.height = kHeight;
  const double view_deg = fisheye ? random.uniform(120.0, 190.0) : random.uniform(40.0, 110.0);
  make_lens(random, fisheye, view_deg, rig.left);
  make_lens(random, fisheye, view_deg, rig.right);
  const double baseline_m = random.uniform(0.05, 0.6);
  rig.T_right_left.R = so3_exp(0.01 * random.vector());
  const double up = random.uniform(-0.01, 0.01), before = random.uniform(-0.01, 0.01);
  rig.T_right_left.t = rig.T_right_left.R * Eigen::Vector3d(-baseline_m, up * baseline_m, before * baseline_m);
  out.board = {BoardKind::charuco, 10, 7, baseline_m / 3.0, 0.75};
  const Eigen::Vector3d middle(out.board.middle().x(), out.board.middle().y(), 0.0);
  const double reach = std::tan(0.5 * std::min(view_deg, 140.0) * kRadian);
  while (static_cast<int>(out.views.size()) < views) {
    const double distance_m = random.uniform(3.0, 9.0) * baseline_m * (fisheye ? 0.6 : 1.0);
    RigidTransform T;
    T.R = so3_exp(0.7 * random.vector());
    const double x = random.uniform(-0.9, 0.9) * reach, y = random.uniform(-0.5, 0.5) * reach;
    T.t = distance_m * Eigen::Vector3d(x, y, 1.0).normalized() - T.R * middle + Eigen::Vector3d(0.5 * baseline_m, 0, 0);
    View view = look(rig, out.board, T);
    if (view.left.size() < 10 || view.right.size() < 10) continue;
    view.name = "view " + std::to_string(out.views.size());
    out.exact.push_back(view);
    for (const Side side : {Side::left, Side::right}) {
      for (SeenCorner& corner : view.of(side)) {
        corner.px.x() += noise_px * random.normal();
        corner.px.y() += noise_px * random.normal();
      }
    }
    out.views.push_back(std::move(view));
    out.T_left_board.push_back(T);
  }
  return out;
}

}  // namespace cliquevo::calibration
