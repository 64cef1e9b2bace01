// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "drivers/simulator/sensor.h"
#include "drivers/simulator/shade.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

// A pixel is the mean of four samples, no two in one column or row, taken one after the other during the exposure. To
// each there is one opposite in place and in time, so that neither shifts the image. They reach a little beyond the
// pixel: its aperture and a sharp lens together (0.45 of the contrast left at the Nyquist frequency, 0.06 at one and a
// half times it), so that what folds back is as little as in a real camera.
struct Sample {
  double x, y, time;
};
constexpr double kSpacing = 0.3125;  // between the samples' columns and rows, px
constexpr Sample kSamples[4] = {{-1.5 * kSpacing, -0.5 * kSpacing, -0.375},
                                {-0.5 * kSpacing, 1.5 * kSpacing, -0.125},
                                {0.5 * kSpacing, -1.5 * kSpacing, 0.125},
                                {1.5 * kSpacing, 0.5 * kSpacing, 0.375}};
// A raw pair is drawn at twice the resolution: two samples a pixel are eight in the end.
constexpr Sample kRawSamples[2] = {{-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25}};

constexpr double kGravelTexelM = 0.0019;
constexpr double kGrassTexelM = 0.0024;

GroundLayer layer(const Tile& tile, double texel_m, double angle, const Eigen::Vector2d& camera) {
  const double c = std::cos(angle) / texel_m;
  const double s = std::sin(angle) / texel_m;
  const auto wrapped = [](double v) { return static_cast<float>(v - Tile::kSize * std::floor(v / Tile::kSize)); };
  GroundLayer l{};
  l.pairs = tile.pairs.data();
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

// Grey levels of ground and sky for one pass.
class Shader {
 public:
  Shader(const View& v, const Ground& g, const ShadeKernels& kernels, const Eigen::Vector2d& drift_m)
      : kernels_(kernels), width_(v.width) {
    const Textures& t = textures();
    to_float(v.ray_start(), ground_.start);
    to_float(v.ray_per_column(), ground_.per_column);
    to_float(v.ray_per_row(), ground_.per_row);
    std::copy_n(ground_.start, 3, sky_.start);
    std::copy_n(ground_.per_column, 3, sky_.per_column);
    std::copy_n(ground_.per_row, 3, sky_.per_row);
    sky_.quads = t.sky.quads.data();
    ground_.gravel = layer(t.gravel, kGravelTexelM, 0.3, v.center.head<2>() + drift_m);
    ground_.grass = layer(t.grass, kGrassTexelM, 1.1, v.center.head<2>() - 0.7 * drift_m);
    ground_.brightness = g.brightness.data();
    ground_.grassiness = g.grassiness.data();
    ground_.grid_columns = g.columns;
    ground_.grid_rows = g.rows;
    ground_.grid_per_m = static_cast<float>(1.0 / Ground::kCellM);
    ground_.grid_x = static_cast<float>(v.center.x() / Ground::kCellM - static_cast<double>(g.first_i));
    ground_.grid_y = static_cast<float>(v.center.y() / Ground::kCellM - static_cast<double>(g.first_j));
    ground_.haze_begin_m = static_cast<float>(kHazeBeginM);
    ground_.haze_per_m = static_cast<float>(1.0 / (kViewRangeM - kHazeBeginM));
    ground_.haze_grey = kHazeGrey;
  }

  void add_row(const Pass& pass, int j, float* sum) const {
    alignas(64) float on_ground[kShadeBlock] = {};
    alignas(64) float in_sky[kShadeBlock] = {};
    const float* w = pass.inverse_depth.row(j);
    const float* grey = pass.grey.row(j);
    const float* light = pass.row_shadowed[static_cast<std::size_t>(j)] != 0 ? pass.light.row(j) : nullptr;
    for (int begin = 0; begin < width_; begin += kShadeBlock) {
      const int n = std::min(kShadeBlock, width_ - begin);
      int ground_pixels = 0;
      int sky_pixels = 0;
      for (int i = begin; i < begin + n; ++i) {
        const int open = grey[i] < 0.0F ? 1 : 0;
        const int hit = w[i] > 0.0F ? 1 : 0;
        ground_pixels += open & hit;
        sky_pixels += open & (1 - hit);
      }
      if (ground_pixels > 0) {
        kernels_.ground(ground_, w, pass.inverse_depth.row(j - 1), pass.inverse_depth.row(j + 1), j, begin, on_ground);
        if (light != nullptr)
          for (int i = 0; i < n; ++i) on_ground[i] *= light[begin + i];
      }
      if (sky_pixels > 0) kernels_.sky(sky_, j, begin, in_sky);
      for (int i = 0; i < n; ++i) {
        const float own = grey[begin + i];
        const float behind = w[begin + i] > 0.0F ? on_ground[i] : in_sky[i];
        sum[begin + i] += own >= 0.0F ? own : behind;
      }
    }
  }

 private:
  const ShadeKernels& kernels_;
  int width_;
  GroundShading ground_{};
  SkyShading sky_{};
};

}  // namespace

Renderer::Renderer(const SimulatorOptions& options, const Course& course, const World& world,
                   const ShadeKernels& kernels)
    : options_(options),
      course_(course),
      world_(world),
      kernels_(kernels),
      calibration_(simulated_calibration(options)) {
  if (!options.raw) return;
  raw_.emplace_back(calibration_.left);
  raw_.emplace_back(calibration_.right);
}

View Renderer::view(const RigidTransform& T_world_left, int side) const {
  View v;
  v.width = options_.width;
  v.height = options_.height;
  v.focal_px = options_.focal_px;
  v.cx_px = 0.5 * (options_.width - 1);
  v.cy_px = 0.5 * (options_.height - 1);
  v.R_world_camera = T_world_left.R;
  v.center = T_world_left.t;
  if (side == 1) {
    v.center += T_world_left.R.col(0) * options_.baseline_m;
    const Eigen::Vector3d off = Eigen::Vector3d(options_.misalign_right_deg[0], options_.misalign_right_deg[1],
                                                options_.misalign_right_deg[2]) *
                                (std::numbers::pi / 180.0);
    if (off.squaredNorm() > 0.0) v.R_world_camera = T_world_left.R * so3_exp(off);
  }
  return v;
}

View Renderer::raw_view(const RigidTransform& T_world_left, int side) const {
  const RawCamera& raw = raw_[static_cast<std::size_t>(side)];
  View v = view(T_world_left, side);
  v.width = raw.width();
  v.height = raw.height();
  v.focal_px = raw.focal_px();
  v.cx_px = raw.cx_px();
  v.cy_px = raw.cy_px();
  // The unknown turn, if any, is one of the camera as it is mounted.
  const Eigen::Matrix3d unknown = T_world_left.R.transpose() * v.R_world_camera;
  const auto& mounted = side == 0 ? calibration_.prescribed->R_left : calibration_.prescribed->R_right;
  v.R_world_camera = T_world_left.R * mounted * unknown;
  return v;
}

void Renderer::collect(const RigidTransform& T_world_left, double frame, RenderScratch& scratch,
                       std::vector<Visible>& visible) const {
  visible.clear();
  world_.near(T_world_left.t.x(), T_world_left.t.y(), 70.0, scratch.near);
  // Sine over cosine of the corner's angle, with some to spare for turned cameras and lenses that see more.
  const double slant = 1.25 * std::hypot(0.5 * options_.width, 0.5 * options_.height) / options_.focal_px;
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

std::vector<Patch> Renderer::patches(const RigidTransform& T_world_left, const std::vector<Visible>& visible) const {
  std::vector<Patch> out;
  for (const Visible& s : visible) {
    Patch patch{};
    if (s.shadow && shadow_of(s.solid, patch)) out.push_back(patch);
  }
  if (options_.shadow) {
    // The sun behind the robot: its body and its mast ahead of the camera, whichever way it turns.
    const Eigen::Vector2d forward = T_world_left.R.col(2).head<2>().normalized();
    const Eigen::Vector2d left(-forward.y(), forward.x());
    const auto add = [&](double ahead, double aside, double half_long, double half_wide) {
      const double h = options_.camera_height_m / 0.85;  // a larger robot has a larger shadow
      const Eigen::Vector2d middle = T_world_left.t.head<2>() + h * (ahead * forward + aside * left);
      out.push_back({middle, forward, h * half_long, h * half_wide, T_world_left.t.z() - options_.camera_height_m,
                     0.4 * h, true, 0.6F});
    };
    add(1.55, 0.15, 0.45, 0.42);
    add(2.25, 0.18, 0.30, 0.07);
  }
  return out;
}

void Renderer::look(const View& v, const std::vector<Visible>& visible, RasterScratch& scratch, Pass& pass) const {
  pass.inverse_depth.resize(v.width, v.height);
  raster_ground(world_.ground(), v, pass.inverse_depth, scratch);
  for (const Visible& s : visible) raster_solid(s.solid, v, s.level, pass.inverse_depth, nullptr);
}

void Renderer::cast(const View& v, const std::vector<Visible>& visible, const std::vector<Patch>& patches,
                    RasterScratch& scratch, Pass& pass) const {
  pass.inverse_depth.resize(v.width, v.height);
  pass.grey.resize(v.width, v.height);
  pass.grey.fill(-1.0F);
  pass.light.resize(v.width, v.height);
  pass.row_shadowed.assign(static_cast<std::size_t>(v.height), 0);
  raster_ground(world_.ground(), v, pass.inverse_depth, scratch);
  for (const Visible& s : visible) raster_solid(s.solid, v, s.level, pass.inverse_depth, &pass.grey);
  for (const Patch& p : patches) raster_patch(p, v, pass.inverse_depth, pass.grey, pass.light, pass.row_shadowed);
}

void Renderer::render(std::int64_t frame, RenderScratch& scratch, CleanPair& out) const {
  const bool raw = !raw_.empty();
  const std::span<const Sample> samples =
      raw ? std::span<const Sample>(kRawSamples) : std::span<const Sample>(kSamples);
  const double exposure = options_.motion_blur ? kExposureS * options_.rate_hz : 0.0;
  std::vector<Shader> shaders[2];
  std::vector<Visible> visible;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double when = static_cast<double>(frame) + exposure * samples[k].time;
    const RigidTransform pose = course_.T_world_camera(when);
    collect(pose, when, scratch, visible);
    // Water: both textures run over the ground, each its own way.
    Eigen::Vector2d drift_m = Eigen::Vector2d::Zero();
    if (options_.scene == "water") drift_m = Eigen::Vector2d(0.9, 0.5) * (when / options_.rate_hz);
    const std::vector<Patch> dark = patches(pose, visible);
    for (int side = 0; side < 2; ++side) {
      View v = raw ? raw_view(pose, side) : view(pose, side);
      v.offset_x = samples[k].x;
      v.offset_y = samples[k].y;
      cast(v, visible, dark, scratch.raster, scratch.passes[side][k]);
      shaders[side].emplace_back(v, world_.ground(), kernels_, drift_m);
    }
  }
  // Row by row through all passes of both cameras: they see the same strip of ground, whose texels stay in the cache.
  Image<std::uint16_t>* const images[2] = {&out.left, &out.right};
  const float scale = static_cast<float>(kGreyScale) / static_cast<float>(samples.size());
  for (int side = 0; side < 2; ++side) {
    const std::size_t w = raw ? raw_[static_cast<std::size_t>(side)].width() : options_.width;
    const std::size_t h = raw ? raw_[static_cast<std::size_t>(side)].height() : options_.height;
    scratch.pinhole[side].assign(w * h, 0.0F);
  }
  const int rows = raw ? std::max(raw_[0].height(), raw_[1].height()) : options_.height;
  for (int j = 0; j < rows; ++j) {
    for (std::size_t side = 0; side < 2; ++side) {
      const int width = raw ? raw_[side].width() : options_.width;
      if (raw && j >= raw_[side].height()) continue;
      float* sum = scratch.pinhole[side].data() + static_cast<std::ptrdiff_t>(j) * width;
      for (std::size_t k = 0; k < samples.size(); ++k) shaders[side][k].add_row(scratch.passes[side][k], j, sum);
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    if (raw) {
      raw_[side].resample(scratch.pinhole[side], scale, static_cast<float>(kGreyMax), *images[side]);
      continue;
    }
    images[side]->resize(options_.width, options_.height);
    const float* sum = scratch.pinhole[side].data();
    for (int j = 0; j < options_.height; ++j) {
      std::uint16_t* row = images[side]->view().row(j);
      for (int i = 0; i < options_.width; ++i)
        row[i] = static_cast<std::uint16_t>(std::clamp(*sum++ * scale + 0.5F, 0.0F, static_cast<float>(kGreyMax)));
    }
  }
}

void Renderer::disparity(std::int64_t frame, RenderScratch& scratch, Image<float>& out) const {
  Pass& pass = scratch.passes[0][0];
  const RigidTransform pose = course_.T_world_camera(static_cast<double>(frame));
  std::vector<Visible> visible;
  collect(pose, static_cast<double>(frame), scratch, visible);
  look(view(pose, 0), visible, scratch.raster, pass);
  out.resize(options_.width, options_.height);
  const auto scale = static_cast<float>(options_.focal_px * options_.baseline_m);
  for (int j = 0; j < options_.height; ++j) {
    const float* w = pass.inverse_depth.row(j);
    float* row = out.view().row(j);
    for (int i = 0; i < options_.width; ++i)
      row[i] = w[i] > 0.0F ? scale * w[i] : std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace cliquevo::drivers::sim
