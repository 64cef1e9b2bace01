// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "drivers/simulator/image_rectangle.h"
#include "drivers/simulator/raster.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

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

// A level between two; what is too fine for the coarsest one fades out.
struct Level {
  int first = 0;
  float between = 0.0F;
  float weight = 1.0F;
  explicit Level(double level) {
    const double limited = std::clamp(level, 0.0, static_cast<double>(SolidTexture::kLastLevel));
    first = std::min(static_cast<int>(limited), SolidTexture::kLastLevel - 1);
    between = static_cast<float>(limited - first);
    weight = static_cast<float>(std::clamp(SolidTexture::kLastLevel - level, 0.0, 1.0));
  }
};

// The same texture once more, smaller: detail for what is seen from near.
constexpr double kFineLevels = 2.1;
constexpr float kFineScale = 4.287F;  // 2^2.1

// About zero.
float trilinear(const SolidTexture& texture, const Level& level, const Eigen::Vector3f& p) {
  const float a = solid_texture(texture, level.first, p.x(), p.y(), p.z());
  const float b = solid_texture(texture, level.first + 1, p.x(), p.y(), p.z());
  return a + level.between * (b - a) - 128.0F;
}

float light_on(const Eigen::Vector3d& normal) {
  const double cosine = normal.x() * kSunX + normal.y() * kSunY + normal.z() * kSunZ;
  // The shadow side gets a little more from above than from below.
  return static_cast<float>(kAmbient * (0.85 + 0.15 * normal.z()) + kDiffuse * std::max(cosine, 0.0));
}

constexpr double kBlotchTexelM = 0.05;

// What a pane shows: a picture of large blotches as far behind it as what it mirrors stands before it, and some of the
// pane's own grey. p: on the pane, d: the ray, both in the pane's frame, whose y is its normal.
float in_glass(const Solid& s, const Eigen::Vector3d& p, const Eigen::Vector3d& d, const Level& level) {
  constexpr double kBehindM = 6.0;
  const double steep = std::max(std::abs(d.y()), 0.05 * d.norm());
  const Eigen::Vector3d seen = p + d * (kBehindM / steep);
  const Eigen::Vector3f t = (seen / kBlotchTexelM).cast<float>() + s.texture_offset.cast<float>();
  return std::clamp(s.albedo + 0.8F * trilinear(textures().stone, level, t), 5.0F, 250.0F);
}

// Share of [x - half, x + half] that lies in the first `part` of every `period`.
double share_of_stripes(double x, double half, double period, double part) {
  const auto before = [&](double v) {
    const double whole = std::floor(v / period);
    return whole * part + std::min(v - whole * period, part);
  };
  return (before(x + half) - before(x - half)) / (2.0 * half);
}

// Grey level beside that of a brick: bricks of 24 x 7 cm, each row half a brick further, with bright joints of 1 cm;
// filtered by the pixel's footprint. p: on the face, metres along and up.
float brick(double along, double up, double footprint_m) {
  constexpr double kLength = 0.25;
  constexpr double kHeight = 0.08;
  constexpr double kJoint = 0.010;
  const double half = std::max(0.5 * footprint_m, 5e-4);
  const double flat = share_of_stripes(up, half, kHeight, kJoint);
  const auto row = static_cast<std::int64_t>(std::floor(up / kHeight));
  const double upright = share_of_stripes(along + (row & 1 ? 0.5 * kLength : 0.0), half, kLength, kJoint);
  const double joint = 1.0 - (1.0 - flat) * (1.0 - upright);
  return static_cast<float>(1.0 + 0.7 * joint);
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
  const Level coarse(level);
  const Level fine(level + kFineLevels);
  const Level blotches(level - std::log2(kBlotchTexelM / s.texel_m));
  const Eigen::Vector3f offset = s.texture_offset.cast<float>();
  const double footprint = 1.5 / view.focal_px;  // of a pixel and its lens, at depth 1

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
      float detail = trilinear(stone, coarse, t);
      if (fine.weight > 0.0F) detail += fine.weight * trilinear(stone, fine, t * kFineScale);
      detail *= s.contrast / 40.0F;
      float lit = s.albedo * light * std::max(1.0F + detail, 0.1F);
      if (s.surface == Solid::Surface::brick) lit *= brick(p.x(), p.z() + s.half_size.z(), enter * footprint);
      if (s.surface == Solid::Surface::glass) lit = in_glass(s, p, d, blotches);
      const auto haze = static_cast<float>(std::clamp((enter - kHazeBeginM) / (kViewRangeM - kHazeBeginM), 0.0, 1.0));
      const float soft = haze * haze * (3.0F - 2.0F * haze);
      grey->row(j)[i] = std::min(lit + soft * (kHazeGrey - lit), 255.0F);
    }
  }
}

}  // namespace cliquevo::drivers::sim
