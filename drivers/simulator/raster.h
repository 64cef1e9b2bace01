// SPDX-License-Identifier: BSD-3-Clause
// Which surface each pixel of a pinhole view sees, and how far away it is: exact ray-surface intersections.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "drivers/simulator/world.h"

namespace cliquevo::drivers::sim {

// A pinhole view; pixel (i, j) samples the image at (i + offset_x, j + offset_y).
struct View {
  int width = 0, height = 0;
  double focal_px = 0.0;
  double cx_px = 0.0, cy_px = 0.0;
  double offset_x = 0.0, offset_y = 0.0;
  Eigen::Matrix3d R_world_camera;
  Eigen::Vector3d center;

  Eigen::Vector3d ray_start() const {
    return R_world_camera * Eigen::Vector3d((offset_x - cx_px) / focal_px, (offset_y - cy_px) / focal_px, 1.0);
  }
  Eigen::Vector3d ray_per_column() const { return R_world_camera.col(0) / focal_px; }
  Eigen::Vector3d ray_per_row() const { return R_world_camera.col(1) / focal_px; }
};

// One value a pixel, with a border that can be read (and is zero).
class Plane {
 public:
  static constexpr int kBorder = 72;
  void resize(int width, int height);
  void fill(float value);
  float* row(int j) { return data_.data() + static_cast<std::ptrdiff_t>(j + 1) * stride_ + kBorder; }
  const float* row(int j) const { return data_.data() + static_cast<std::ptrdiff_t>(j + 1) * stride_ + kBorder; }

 private:
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<float> data_;
};

struct RasterScratch {
  std::vector<double> u[2], v[2], depth[2];  // two rows of projected vertices
};

// 1/depth of the ground; the larger of what is there and the ground stays. `inverse_depth` holds 0 where nothing is.
void raster_ground(const Ground& ground, const View& view, Plane& inverse_depth, RasterScratch& scratch);

// A solid in front of what is there: its 1/depth and, unless `grey` is null, its grey level. `level` is the level of
// the solid texture that suits its distance.
void raster_solid(const Solid& solid, const View& view, double level, Plane& inverse_depth, Plane* grey);

// A dark patch on the ground with a soft edge: an ellipse, or a rounded rectangle.
struct Patch {
  Eigen::Vector2d middle;  // world
  Eigen::Vector2d axis;    // unit vector
  double half_long_m, half_wide_m;
  double ground_m;        // height of the ground there, about
  double ground_slack_m;  // and by how much it may differ
  bool rectangle;
  float darkness;  // 0 to 1
};

// The shadow of a solid on level ground; false when it casts none.
bool shadow_of(const Solid& solid, Patch& patch);

// Darkens light[] where the ground lies in the patch; rows that were touched for the first time begin as 1.
void raster_patch(const Patch& patch, const View& view, const Plane& inverse_depth, const Plane& grey, Plane& light,
                  std::vector<char>& row_touched);

}  // namespace cliquevo::drivers::sim
