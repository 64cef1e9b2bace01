// SPDX-License-Identifier: BSD-3-Clause
// What is rendered: the ground as a grid of triangles, and convex solids standing on it. Everything is a function of
// the seed and of where it is, so that the part of the world that is made does not change what it looks like.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "drivers/simulator/course.h"

namespace cliquevo::drivers::sim {

// Light comes from here (world frame); kAmbient + kDiffuse * cosine, and level ground has brightness 1.
inline constexpr double kSunX = 0.55;
inline constexpr double kSunY = 0.48;
inline constexpr double kSunZ = 0.683;
inline constexpr double kAmbient = 0.42;
inline constexpr double kDiffuse = (1.0 - kAmbient) / kSunZ;
inline constexpr double kViewRangeM = 85.0;  // the ground fades into haze until here
inline constexpr double kHazeBeginM = 40.0;
inline constexpr float kHazeGrey = 150.0F;

// A quadric (in its own frame: sum of curvature_i x_i^2 <= 1; zero: unbounded along that axis) cut by planes
// normal . x <= distance.
struct Solid {
  static constexpr int kMaxPlanes = 8;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_world_local = Eigen::Matrix3d::Identity();
  Eigen::Vector3d curvature = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();  // box around it, own frame
  int planes = 0;
  std::array<Eigen::Vector3d, kMaxPlanes> normal = no_planes();
  std::array<double, kMaxPlanes> distance{};
  float albedo = 100.0F;
  float contrast = 0.3F;
  double texel_m = 0.004;
  Eigen::Vector3d texture_offset = Eigen::Vector3d::Zero();
  double foot_radius_m = 0.0;  // of the shadow's round end; 0 = no shadow
  double top_m = 0.0;          // height above ground
  double ground_m = 0.0;
  enum class Surface { stone, brick, glass };
  Surface surface = Surface::stone;

  static std::array<Eigen::Vector3d, kMaxPlanes> no_planes() {
    std::array<Eigen::Vector3d, kMaxPlanes> n;
    n.fill(Eigen::Vector3d::Zero());
    return n;
  }
};

// Regular grid of the ground. Vertex (i, j) is at world ((i + first_i) * cell, (j + first_j) * cell); each cell is
// split from its lower left to its upper right vertex.
struct Ground {
  static constexpr double kCellM = 0.75;
  int first_i = 0, first_j = 0;
  int columns = 0, rows = 0;
  std::vector<float> height;
  std::vector<std::uint32_t> brightness;  // quads as Tile: grey level of the ground, light on it included
  std::vector<std::uint32_t> grassiness;  // 0 gravel, 255 grass

  float at(int i, int j) const { return height[static_cast<std::size_t>(j) * columns + i]; }
};

class World {
 public:
  World(const SimulatorOptions& options, const Course& course);

  const Ground& ground() const { return ground_; }
  // Indices into solids() of what may be seen from within `range_m` of a point.
  void near(double x, double y, double range_m, std::vector<int>& indices) const;
  const std::vector<Solid>& solids() const { return solids_; }
  // Moving things at a (fractional) frame.
  std::vector<Solid> movers(double frame) const;

 private:
  void make_ground();
  void make_solids();
  void bin_solids(const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  void make_railing();
  void make_walls();
  void add_rock(double x, double y, double radius, std::uint64_t seed);
  Solid box(const Eigen::Vector2d& place, double yaw, const Eigen::Vector3d& half_size) const;
  Solid lorry(double frame) const;
  void add_post(double x, double y, std::uint64_t seed);

  SimulatorOptions options_;
  const Course& course_;
  Ground ground_;
  std::vector<Solid> solids_;
  static constexpr double kBinM = 8.0;
  int bin_first_x_ = 0, bin_first_y_ = 0;
  int bin_columns_ = 0, bin_rows_ = 0;
  std::vector<std::vector<int>> bins_;
};

}  // namespace cliquevo::drivers::sim
