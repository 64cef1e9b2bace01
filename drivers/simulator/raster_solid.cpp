// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "drivers/simulator/raster.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kNearM = 0.12;

struct Rectangle {
  int i0, i1, j0, j1;  // i1, j1 excluded
  bool empty() const { return i0 >= i1 || j0 >= j1; }
};

// Image rectangle around points given in camera coordinates; the whole image when one of them is behind it.
Rectangle around(const View& view, const Eigen::Vector3d* points, int count) {
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

float solid_texture(const SolidTexture& texture, int level, float x, float y, float z) {
  const int bits = SolidTexture::kLog2Size - level;
  const int mask = (1 << bits) - 1;
  const float scale = 1.0F / static_cast<float>(1 << level);
  x = x * scale - 0.5F;
  y = y * scale - 0.5F;
  z = z * scale - 0.5F;
  const float fx = std::floor(x);
  const float fy = std::floor(y);
  const float fz = std::floor(z);
  const int ix = static_cast<int>(fx) & mask;
  const int iy = static_cast<int>(fy) & mask;
  const int iz = static_cast<int>(fz);
  const std::uint32_t* base = texture.quads.data() + texture.level_start[static_cast<std::size_t>(level)];
  float slice[2];
  for (int k = 0; k < 2; ++k) {
    const std::uint32_t q = base[(((iz + k) & mask) << (2 * bits)) + (iy << bits) + ix];
    const auto a = static_cast<float>(q & 255U);
    const auto b = static_cast<float>((q >> 8) & 255U);
    const auto c = static_cast<float>((q >> 16) & 255U);
    const auto d = static_cast<float>(q >> 24);
    const float top = a + (x - fx) * (b - a);
    const float bottom = c + (x - fx) * (d - c);
    slice[k] = top + (y - fy) * (bottom - top);
  }
  return slice[0] + (z - fz) * (slice[1] - slice[0]);
}

float light_on(const Eigen::Vector3d& normal) {
  const double cosine = normal.x() * kSunX + normal.y() * kSunY + normal.z() * kSunZ;
  // The shadow side gets a little more from above than from below.
  return static_cast<float>(kAmbient * (0.85 + 0.15 * normal.z()) + kDiffuse * std::max(cosine, 0.0));
}

}  // namespace

void raster_solid(const Solid& s, const View& view, double level, Plane& inverse_depth, Plane* grey) {
  const Eigen::Matrix3d R = view.R_world_camera.transpose();
  const Eigen::Vector3d center = R * (s.center - view.center);
  const double reach = s.half_size.norm();
  if (center.z() < -reach) return;
  Eigen::Vector3d corners[8];
  const Eigen::Matrix3d R_camera_local = R * s.R_world_local;
  for (int k = 0; k < 8; ++k) {
    corners[k] = center + R_camera_local * Eigen::Vector3d((k & 1 ? 1.0 : -1.0) * s.half_size.x(),
                                                           (k & 2 ? 1.0 : -1.0) * s.half_size.y(),
                                                           (k & 4 ? 1.0 : -1.0) * s.half_size.z());
  }
  const Rectangle box = around(view, corners, 8);
  if (box.empty()) return;

  // Rays in the solid's own frame: origin o, direction d with unit depth, so the parameter is the depth.
  const Eigen::Matrix3d R_local_world = s.R_world_local.transpose();
  const Eigen::Vector3d o = R_local_world * (view.center - s.center);
  const Eigen::Vector3d d_start = R_local_world * view.ray_start();
  const Eigen::Vector3d d_column = R_local_world * view.ray_per_column();
  const Eigen::Vector3d d_row = R_local_world * view.ray_per_row();
  const Eigen::Vector3d weighted = s.curvature.cwiseProduct(o);
  const bool has_quadric = s.curvature.squaredNorm() > 0.0;
  const double c = weighted.dot(o) - 1.0;
  double plane_c[Solid::kMaxPlanes];
  float plane_light[Solid::kMaxPlanes];
  for (int k = 0; k < s.planes; ++k) {
    plane_c[k] = s.distance[k] - s.normal[k].dot(o);
    plane_light[k] = light_on(s.R_world_local * s.normal[k]);
  }
  const SolidTexture& stone = textures().stone;
  const auto per_texel = static_cast<float>(1.0 / s.texel_m);
  const double limited = std::clamp(level, 0.0, static_cast<double>(SolidTexture::kLastLevel));
  const int level0 = std::min(static_cast<int>(limited), SolidTexture::kLastLevel - 1);
  const auto between = static_cast<float>(limited - level0);
  const Eigen::Vector3f offset = s.texture_offset.cast<float>();

  for (int j = box.j0; j < box.j1; ++j) {
    float* w_row = inverse_depth.row(j);
    const Eigen::Vector3d d_of_row = d_start + j * d_row;
    for (int i = box.i0; i < box.i1; ++i) {
      const Eigen::Vector3d d = d_of_row + i * d_column;
      double enter = kNearM;
      double leave = 1e9;
      int face = -1;
      if (has_quadric) {
        const double a =
            s.curvature.x() * d.x() * d.x() + s.curvature.y() * d.y() * d.y() + s.curvature.z() * d.z() * d.z();
        const double b = weighted.dot(d);
        const double disc = b * b - a * c;
        if (disc <= 0.0 || a < 1e-12) continue;
        const double root = std::sqrt(disc);
        const double near = (-b - root) / a;
        if (near > enter) {
          enter = near;
          face = Solid::kMaxPlanes;
        }
        leave = (-b + root) / a;
      }
      for (int k = 0; k < s.planes; ++k) {
        const double along = s.normal[k].dot(d);
        if (along < 0.0) {
          if (plane_c[k] < enter * along) {
            enter = plane_c[k] / along;
            face = k;
          }
        } else if (plane_c[k] < leave * along) {
          leave = plane_c[k] / along;
        }
      }
      if (face < 0 || enter >= leave) continue;
      const auto w = static_cast<float>(1.0 / enter);
      if (w <= w_row[i]) continue;
      w_row[i] = w;
      if (grey == nullptr) continue;
      const Eigen::Vector3d p = o + enter * d;
      const float light = face < Solid::kMaxPlanes
                              ? plane_light[face]
                              : light_on((s.R_world_local * s.curvature.cwiseProduct(p)).normalized());
      const Eigen::Vector3f t = p.cast<float>() * per_texel + offset;
      const float coarse = solid_texture(stone, level0, t.x(), t.y(), t.z());
      const float coarser = solid_texture(stone, level0 + 1, t.x(), t.y(), t.z());
      const float detail = (coarse + between * (coarser - coarse) - 128.0F) * (s.contrast / 40.0F);
      const float lit = s.albedo * light * std::max(1.0F + detail, 0.1F);
      const auto haze = static_cast<float>(std::clamp((enter - kHazeBeginM) / (kViewRangeM - kHazeBeginM), 0.0, 1.0));
      const float soft = haze * haze * (3.0F - 2.0F * haze);
      grey->row(j)[i] = std::min(lit + soft * (kHazeGrey - lit), 255.0F);
    }
  }
}

void raster_shadow(const Solid& s, const View& view, const Plane& inverse_depth, const Plane& grey, Plane& light,
                   std::vector<char>& row_touched) {
  if (s.foot_radius_m <= 0.0) return;
  // On level ground: an ellipse from the foot away from the sun.
  const double sun = std::hypot(kSunX, kSunY);
  const Eigen::Vector2d away(-kSunX / sun, -kSunY / sun);
  const double length = s.top_m * sun / kSunZ;
  const double half_long = s.foot_radius_m + 0.5 * length;
  const double half_wide = s.foot_radius_m;
  const Eigen::Vector2d middle = s.center.head<2>() + 0.5 * length * away;
  const Eigen::Vector2d across(-away.y(), away.x());
  constexpr double kSoft = 1.25;  // the penumbra reaches to here
  const Eigen::Matrix3d R = view.R_world_camera.transpose();
  Eigen::Vector3d corners[8];
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector2d p =
        middle + (k & 1 ? kSoft : -kSoft) * half_long * away + (k & 2 ? kSoft : -kSoft) * half_wide * across;
    const double slack = 0.04 + 0.25 * half_long;  // the ground slopes
    corners[k] = R * (Eigen::Vector3d(p.x(), p.y(), s.ground_m + (k & 4 ? slack : -slack)) - view.center);
  }
  const Rectangle box = around(view, corners, 8);
  if (box.empty()) return;
  const Eigen::Vector3d start = view.ray_start();
  const Eigen::Vector3d column = view.ray_per_column();
  const Eigen::Vector3d row = view.ray_per_row();
  const Eigen::Vector2d from_middle = view.center.head<2>() - middle;
  const auto oa = static_cast<float>(from_middle.dot(away) / half_long);
  const auto ob = static_cast<float>(from_middle.dot(across) / half_wide);
  for (int j = box.j0; j < box.j1; ++j) {
    const Eigen::Vector2d r0 = (start + j * row).head<2>();
    const auto a0 = static_cast<float>(r0.dot(away) / half_long);
    const auto a1 = static_cast<float>(column.head<2>().dot(away) / half_long);
    const auto b0 = static_cast<float>(r0.dot(across) / half_wide);
    const auto b1 = static_cast<float>(column.head<2>().dot(across) / half_wide);
    const float* w = inverse_depth.row(j);
    const float* g = grey.row(j);
    float* out = light.row(j);
    if (row_touched[static_cast<std::size_t>(j)] == 0) {
      row_touched[static_cast<std::size_t>(j)] = 1;
      std::fill(out - Plane::kBorder, out + view.width + Plane::kBorder, 1.0F);
    }
    for (int i = box.i0; i < box.i1; ++i) {
      if (g[i] >= 0.0F || w[i] <= 0.0F) continue;
      const float z = 1.0F / w[i];
      const float a = oa + z * (a0 + static_cast<float>(i) * a1);
      const float b = ob + z * (b0 + static_cast<float>(i) * b1);
      const float r2 = a * a + b * b;
      constexpr float kOuter = 1.5625F;  // 1.25 squared
      if (r2 >= kOuter) continue;
      const float t = std::min((kOuter - r2) * (1.0F / (kOuter - 0.55F)), 1.0F);
      out[i] *= 1.0F - 0.5F * t * t * (3.0F - 2.0F * t);
    }
  }
}

}  // namespace cliquevo::drivers::sim
