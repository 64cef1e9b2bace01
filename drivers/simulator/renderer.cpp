// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/simulator/shade.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

// A pixel is the mean of four samples, no two in one column or row, taken one after the other during the exposure. To
// each there is one opposite in place and in time, so that neither shifts the image.
struct Sample {
  double x, y, time;
};
constexpr Sample kSamples[4] = {
    {-0.375, -0.125, -0.375}, {-0.125, 0.375, -0.125}, {0.125, -0.375, 0.125}, {0.375, 0.125, 0.375}};
constexpr double kExposureS = 0.003;

constexpr double kGravelTexelM = 0.0019;
constexpr double kGrassTexelM = 0.0024;

GroundLayer layer(const Tile& tile, double texel_m, double angle, const Eigen::Vector3d& camera) {
  const double c = std::cos(angle) / texel_m;
  const double s = std::sin(angle) / texel_m;
  const auto wrapped = [](double v) { return static_cast<float>(v - Tile::kSize * std::floor(v / Tile::kSize)); };
  GroundLayer l{};
  l.quads = tile.quads.data();
  l.axis_u[0] = static_cast<float>(c);
  l.axis_u[1] = static_cast<float>(s);
  l.axis_v[0] = static_cast<float>(-s);
  l.axis_v[1] = static_cast<float>(c);
  l.origin_u = wrapped(c * camera.x() + s * camera.y());
  l.origin_v = wrapped(c * camera.y() - s * camera.x());
  l.texels_per_m = static_cast<float>(1.0 / texel_m);
  return l;
}

void to_float(const Eigen::Vector3d& v, float (&out)[3]) {
  for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(v[k]);
}

}  // namespace

Renderer::Renderer(const SimulatorOptions& options, const Course& course, const World& world)
    : options_(options), course_(course), world_(world) {}

View Renderer::view(const RigidTransform& T_world_left, int eye) const {
  View v;
  v.width = options_.width;
  v.height = options_.height;
  v.focal_px = options_.focal_px;
  v.cx_px = 0.5 * (options_.width - 1);
  v.cy_px = 0.5 * (options_.height - 1);
  v.R_world_camera = T_world_left.R;
  v.center = T_world_left.t;
  if (eye == 1) {
    v.center += T_world_left.R.col(0) * options_.baseline_m;
    const Eigen::Vector3d off = Eigen::Vector3d(options_.misalign_right_deg[0], options_.misalign_right_deg[1],
                                                options_.misalign_right_deg[2]) *
                                (std::numbers::pi / 180.0);
    if (off.squaredNorm() > 0.0) v.R_world_camera = T_world_left.R * so3_exp(off);
  }
  return v;
}

void Renderer::collect(const RigidTransform& T_world_left, double frame, RenderScratch& scratch,
                       std::vector<Visible>& visible) const {
  visible.clear();
  world_.near(T_world_left.t.x(), T_world_left.t.y(), 70.0, scratch.near);
  const double slant = std::hypot(0.5 * options_.width, 0.5 * options_.height) / options_.focal_px;
  const auto add = [&](const Solid& s) {
    const Eigen::Vector3d p = T_world_left.R.transpose() * (s.center - T_world_left.t);
    const double reach = s.half_size.norm() + 2.5 * s.top_m;  // with its shadow
    if (p.z() < -reach || p.head<2>().norm() > (p.z() + reach) * slant + reach + 0.5) return;
    const double distance = p.norm();
    const double size_px = options_.focal_px * s.half_size.maxCoeff() / std::max(distance, 0.1);
    if (size_px < 0.45) return;
    visible.push_back({s, std::log2(std::max(0.6 * distance / (options_.focal_px * s.texel_m), 1.0)), size_px > 1.2});
  };
  for (const int n : scratch.near) add(world_.solids()[static_cast<std::size_t>(n)]);
  for (const Solid& s : world_.movers(frame)) add(s);
}

void Renderer::depth(const View& v, const std::vector<Visible>& visible, RenderScratch& scratch, Plane* grey) const {
  scratch.inverse_depth.fill(0.0F);
  raster_ground(world_.ground(), v, scratch.inverse_depth, scratch.raster);
  for (const Visible& s : visible) raster_solid(s.solid, v, s.level, scratch.inverse_depth, grey);
}

// Adds the view's grey levels to scratch.sum.
void Renderer::shade(const View& v, RenderScratch& scratch) const {
  const Textures& t = textures();
  const Ground& g = world_.ground();
  const ShadeKernels& kernels = shade_kernels();
  GroundShading ground{};
  SkyShading sky{};
  to_float(v.ray_start(), ground.start);
  to_float(v.ray_per_column(), ground.per_column);
  to_float(v.ray_per_row(), ground.per_row);
  std::copy_n(ground.start, 3, sky.start);
  std::copy_n(ground.per_column, 3, sky.per_column);
  std::copy_n(ground.per_row, 3, sky.per_row);
  sky.quads = t.sky.quads.data();
  ground.gravel = layer(t.gravel, kGravelTexelM, 0.3, v.center);
  ground.grass = layer(t.grass, kGrassTexelM, 1.1, v.center);
  ground.brightness = g.brightness.data();
  ground.grassiness = g.grassiness.data();
  ground.grid_columns = g.columns;
  ground.grid_rows = g.rows;
  ground.grid_per_m = static_cast<float>(1.0 / Ground::kCellM);
  ground.grid_x = static_cast<float>(v.center.x() / Ground::kCellM - static_cast<double>(g.first_i));
  ground.grid_y = static_cast<float>(v.center.y() / Ground::kCellM - static_cast<double>(g.first_j));
  ground.haze_begin_m = static_cast<float>(kHazeBeginM);
  ground.haze_per_m = static_cast<float>(1.0 / (kViewRangeM - kHazeBeginM));
  ground.haze_grey = kHazeGrey;

  alignas(64) float on_ground[kShadeBlock];
  alignas(64) float in_sky[kShadeBlock];
  for (int j = 0; j < v.height; ++j) {
    const float* w = scratch.inverse_depth.row(j);
    const float* grey = scratch.grey.row(j);
    const float* light = scratch.row_shadowed[static_cast<std::size_t>(j)] != 0 ? scratch.light.row(j) : nullptr;
    float* sum = &scratch.sum[static_cast<std::size_t>(j) * v.width];
    for (int begin = 0; begin < v.width; begin += kShadeBlock) {
      const int n = std::min(kShadeBlock, v.width - begin);
      bool any_ground = false;
      bool any_sky = false;
      for (int i = begin; i < begin + n; ++i) {
        any_ground |= grey[i] < 0.0F && w[i] > 0.0F;
        any_sky |= grey[i] < 0.0F && w[i] <= 0.0F;
      }
      if (any_ground) {
        kernels.ground(ground, w, scratch.inverse_depth.row(j - 1), scratch.inverse_depth.row(j + 1), j, begin,
                       on_ground);
        if (light != nullptr)
          for (int i = 0; i < n; ++i) on_ground[i] *= light[begin + i];
      }
      if (any_sky) kernels.sky(sky, j, begin, in_sky);
      for (int i = 0; i < n; ++i) {
        const float value =
            grey[begin + i] >= 0.0F ? grey[begin + i] : (w[begin + i] > 0.0F ? on_ground[i] : in_sky[i]);
        sum[begin + i] += value;
      }
    }
  }
}

void Renderer::render(std::int64_t frame, RenderScratch& scratch, CleanPair& out) const {
  const int width = options_.width;
  const int height = options_.height;
  scratch.inverse_depth.resize(width, height);
  scratch.grey.resize(width, height);
  scratch.light.resize(width, height);
  const double exposure = options_.motion_blur ? kExposureS * options_.rate_hz : 0.0;
  std::vector<Visible> visible[4];
  RigidTransform pose[4];
  for (int k = 0; k < 4; ++k) {
    const double when = static_cast<double>(frame) + exposure * kSamples[k].time;
    pose[k] = course_.T_world_camera(when);
    collect(pose[k], when, scratch, visible[k]);
  }
  for (int eye = 0; eye < 2; ++eye) {
    scratch.sum.assign(static_cast<std::size_t>(width) * height, 0.0F);
    for (int k = 0; k < 4; ++k) {
      View v = view(pose[k], eye);
      v.offset_x = kSamples[k].x;
      v.offset_y = kSamples[k].y;
      scratch.grey.fill(-1.0F);
      scratch.row_shadowed.assign(static_cast<std::size_t>(height), 0);
      depth(v, visible[k], scratch, &scratch.grey);
      for (const Visible& s : visible[k]) {
        if (s.shadow)
          raster_shadow(s.solid, v, scratch.inverse_depth, scratch.grey, scratch.light, scratch.row_shadowed);
      }
      shade(v, scratch);
    }
    Image<std::uint16_t>& image = eye == 0 ? out.left : out.right;
    image.resize(width, height);
    for (int j = 0; j < height; ++j) {
      const float* sum = &scratch.sum[static_cast<std::size_t>(j) * width];
      std::uint16_t* row = image.view().row(j);
      for (int i = 0; i < width; ++i) {
        const float v = sum[i] * (kGreyScale / 4.0F) + 0.5F;
        row[i] = static_cast<std::uint16_t>(std::clamp(v, 0.0F, static_cast<float>(kGreyMax)));
      }
    }
  }
}

void Renderer::disparity(std::int64_t frame, RenderScratch& scratch, Image<float>& out) const {
  scratch.inverse_depth.resize(options_.width, options_.height);
  const RigidTransform pose = course_.T_world_camera(static_cast<double>(frame));
  std::vector<Visible> visible;
  collect(pose, static_cast<double>(frame), scratch, visible);
  depth(view(pose, 0), visible, scratch, nullptr);
  out.resize(options_.width, options_.height);
  const auto scale = static_cast<float>(options_.focal_px * options_.baseline_m);
  for (int j = 0; j < options_.height; ++j) {
    const float* w = scratch.inverse_depth.row(j);
    float* row = out.view().row(j);
    for (int i = 0; i < options_.width; ++i)
      row[i] = w[i] > 0.0F ? scale * w[i] : std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace cliquevo::drivers::sim
