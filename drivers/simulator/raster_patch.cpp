// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "drivers/simulator/image_rectangle.h"
#include "drivers/simulator/raster.h"

namespace cliquevo::drivers::sim {

bool shadow_of(const Solid& s, Patch& patch) {
  if (s.foot_radius_m <= 0.0) return false;
  // From the foot away from the sun.
  const double sun = std::hypot(kSunX, kSunY);
  const double length = s.top_m * sun / kSunZ;
  patch.axis = {-kSunX / sun, -kSunY / sun};
  patch.half_long_m = s.foot_radius_m + 0.5 * length;
  patch.half_wide_m = s.foot_radius_m;
  patch.middle = s.center.head<2>() + 0.5 * length * patch.axis;
  patch.ground_m = s.ground_m;
  patch.ground_slack_m = 0.04 + 0.15 * patch.half_long_m;  // slopes up to 15 %
  patch.rectangle = false;
  patch.darkness = 0.5F;
  return true;
}

void raster_patch(const Patch& patch, const View& view, const Plane& inverse_depth, const Plane& grey, Plane& light,
                  std::vector<char>& row_touched) {
  const Eigen::Vector2d across(-patch.axis.y(), patch.axis.x());
  constexpr double kSoft = 1.25;     // the edge is soft until here, in half sizes
  constexpr float kOuter = 1.5625F;  // its square
  const Eigen::Matrix3d R = view.R_world_camera.transpose();
  Eigen::Vector3d corners[8];
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector2d p = patch.middle + (k & 1 ? kSoft : -kSoft) * patch.half_long_m * patch.axis +
                              (k & 2 ? kSoft : -kSoft) * patch.half_wide_m * across;
    const double height = patch.ground_m + (k & 4 ? patch.ground_slack_m : -patch.ground_slack_m);
    corners[k] = R * (Eigen::Vector3d(p.x(), p.y(), height) - view.center);
  }
  const Rectangle box = around(view, corners, 8);
  if (box.empty()) return;
  const Eigen::Vector3d start = view.ray_start();
  const Eigen::Vector3d column = view.ray_per_column();
  const Eigen::Vector3d row = view.ray_per_row();
  const Eigen::Vector2d from_middle = view.center.head<2>() - patch.middle;
  const auto oa = static_cast<float>(from_middle.dot(patch.axis) / patch.half_long_m);
  const auto ob = static_cast<float>(from_middle.dot(across) / patch.half_wide_m);
  const auto a1 = static_cast<float>(column.head<2>().dot(patch.axis) / patch.half_long_m);
  const auto b1 = static_cast<float>(column.head<2>().dot(across) / patch.half_wide_m);
  for (int j = box.j0; j < box.j1; ++j) {
    const Eigen::Vector2d r0 = (start + j * row).head<2>();
    const auto a0 = static_cast<float>(r0.dot(patch.axis) / patch.half_long_m);
    const auto b0 = static_cast<float>(r0.dot(across) / patch.half_wide_m);
    const float* w = inverse_depth.row(j);
    const float* g = grey.row(j);
    float* out = light.row(j);
    if (row_touched[static_cast<std::size_t>(j)] == 0) {
      row_touched[static_cast<std::size_t>(j)] = 1;
      std::fill(out - Plane::kBorder, out + view.width + Plane::kBorder, 1.0F);
    }
    // No branches: four or eight pixels at a time.
    for (int i = box.i0; i < box.i1; ++i) {
      const float inverse = w[i] > 1e-3F ? w[i] : 1e-3F;
      const float z = 1.0F / inverse;
      const float a = oa + z * (a0 + static_cast<float>(i) * a1);
      const float b = ob + z * (b0 + static_cast<float>(i) * b1);
      const float r2 = patch.rectangle ? __builtin_sqrtf(a * a * a * a + b * b * b * b) : a * a + b * b;
      const float inside = (kOuter - r2) * (1.0F / (kOuter - 0.55F));
      const float t = inside < 0.0F ? 0.0F : (inside > 1.0F ? 1.0F : inside);
      const float factor = 1.0F - patch.darkness * t * t * (3.0F - 2.0F * t);
      out[i] *= g[i] < 0.0F ? factor : 1.0F;
    }
  }
}

}  // namespace cliquevo::drivers::sim
