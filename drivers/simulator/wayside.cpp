// SPDX-License-Identifier: BSD-3-Clause
// What people build beside a way: railings, walls, panes. Places are functions of the way alone.
#include <cmath>
#include <numbers>

#include "drivers/simulator/hash.h"
#include "drivers/simulator/world.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kAsideM = 2.4;  // from the middle of the way

// The part of the course beside which something is built: a lap, or as far as is driven and seen.
double built_length(const Course& course) {
  return std::isfinite(course.lap_m()) ? course.lap_m() : course.length_m() + kViewRangeM;
}

// left: 1, right: -1
Eigen::Vector2d beside(const Course& course, double s, double aside_m) {
  const double psi = course.heading(s);
  return course.position(s) + aside_m * Eigen::Vector2d(-std::sin(psi), std::cos(psi));
}

}  // namespace

// Upright bars of 3 cm every 12 cm, a metre high, all alike, under a rail in pieces of 1.2 m.
void World::make_railing() {
  constexpr double kPitchM = 0.12;
  constexpr double kRadiusM = 0.015;
  constexpr double kHeightM = 1.0;
  constexpr int kBarsAPiece = 10;
  const int bars = static_cast<int>(built_length(course_) / kPitchM);
  for (int k = 0; k < bars; ++k) {
    const Eigen::Vector2d at = beside(course_, kPitchM * k, kAsideM);
    Solid bar;
    bar.ground_m = course_.terrain().height(at.x(), at.y());
    bar.center = {at.x(), at.y(), bar.ground_m + 0.5 * kHeightM - 0.05};
    bar.half_size = {kRadiusM, kRadiusM, 0.5 * kHeightM + 0.05};
    bar.planes = 2;
    bar.normal[0] = {0.0, 0.0, 1.0};
    bar.normal[1] = {0.0, 0.0, -1.0};
    bar.distance[0] = bar.distance[1] = bar.half_size.z();
    bar.curvature = {1.0 / (kRadiusM * kRadiusM), 1.0 / (kRadiusM * kRadiusM), 0.0};
    bar.albedo = 60.0F;
    bar.contrast = 0.05F;
    solids_.push_back(bar);
    if (k % kBarsAPiece != 0) continue;
    const Eigen::Vector2d next = beside(course_, kPitchM * (k + kBarsAPiece), kAsideM);
    const Eigen::Vector2d middle = 0.5 * (at + next);
    Solid rail = box(middle, std::atan2((next - at).y(), (next - at).x()), {0.5 * (next - at).norm(), 0.025, 0.025});
    rail.center.z() = rail.ground_m + kHeightM;
    rail.albedo = 60.0F;
    rail.contrast = 0.05F;
    rail.foot_radius_m = 0.0;
    solids_.push_back(rail);
  }
}

// Pieces of 4 m and 2 m high, in turn bricks and glass where both are wanted, with a gap of 4 m where not.
void World::make_walls() {
  constexpr double kPieceM = 4.0;
  const int pieces = static_cast<int>(built_length(course_) / kPieceM);
  for (int k = 0; k < pieces; ++k) {
    const bool glass = k % 2 == 1;
    if (glass ? !options_.glass : !options_.walls) continue;
    const Eigen::Vector2d from = beside(course_, kPieceM * k, -kAsideM);
    const Eigen::Vector2d to = beside(course_, kPieceM * (k + 1), -kAsideM);
    const Eigen::Vector2d way = to - from;
    Solid piece = box(0.5 * (from + to), std::atan2(way.y(), way.x()), {0.5 * way.norm(), 0.06, 1.0});
    piece.center.z() -= 0.15;  // into the ground
    piece.foot_radius_m = 0.0;
    piece.surface = glass ? Solid::Surface::glass : Solid::Surface::brick;
    piece.albedo = glass ? 120.0F : 85.0F;
    piece.contrast = 0.08F;
    Random random(hash_cell(mix64(options_.world_seed ^ 0x77616c6cULL), k, 0));
    for (int axis = 0; axis < 3; ++axis) piece.texture_offset[axis] = random.uniform(0.0, 64.0);
    solids_.push_back(piece);
  }
}

}  // namespace cliquevo::drivers::sim
