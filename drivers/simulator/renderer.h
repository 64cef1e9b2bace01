// SPDX-License-Identifier: BSD-3-Clause
// Noise-free images of the stereo pair and their exact depth.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/raster.h"
#include "drivers/simulator/raw_pair.h"
#include "drivers/simulator/shade.h"
#include "drivers/simulator/world.h"

namespace cliquevo::drivers::sim {

// Grey levels are kept in sixteenths: far below any sensor's noise, and 12 bits a pixel.
inline constexpr int kGreyScale = 16;
inline constexpr int kGreyMax = 4095;
// Raised whenever the same options give other images: old caches are then left alone.
inline constexpr int kRenderVersion = 4;

struct CleanPair {
  Image<std::uint16_t> left, right;
};

// One look at the world: a pixel of an image is the mean of several.
struct Pass {
  Plane inverse_depth;  // 0 = nothing there
  Plane grey;           // of solids; negative elsewhere
  Plane light;          // on the ground, in rows with row_shadowed
  std::vector<char> row_shadowed;
};

// What one thread needs for rendering.
struct RenderScratch {
  static constexpr int kMostPasses = 4;
  Pass passes[2][kMostPasses];
  std::vector<float> pinhole[2];  // raw pairs: what the lens then distorts
  RasterScratch raster;
  std::vector<int> near;
};

class Renderer {
 public:
  Renderer(const SimulatorOptions& options, const Course& course, const World& world,
           const ShadeKernels& kernels = shade_kernels());

  // Safe from several threads, each with its scratch.
  void render(std::int64_t frame, RenderScratch& scratch, CleanPair& out) const;
  // Disparity of the rectified left image, px; NaN where the ray meets nothing (sky, far hills).
  void disparity(std::int64_t frame, RenderScratch& scratch, Image<float>& out) const;

 private:
  struct Visible {
    Solid solid;
    double level;
    bool shadow;
  };
  View view(const RigidTransform& T_world_left, int side) const;  // rectified
  View raw_view(const RigidTransform& T_world_left, int side) const;
  void collect(const RigidTransform& T_world_left, double frame, RenderScratch& scratch,
               std::vector<Visible>& visible) const;
  // Shadows on the ground, the robot's own among them.
  std::vector<Patch> patches(const RigidTransform& T_world_left, const std::vector<Visible>& visible) const;
  // 1/depth alone.
  void look(const View& view, const std::vector<Visible>& visible, RasterScratch& scratch, Pass& pass) const;
  // 1/depth, the grey levels of solids, the light on the ground.
  void cast(const View& view, const std::vector<Visible>& visible, const std::vector<Patch>& patches,
            RasterScratch& scratch, Pass& pass) const;

  const SimulatorOptions& options_;
  const Course& course_;
  const World& world_;
  const ShadeKernels& kernels_;
  StereoCalibration calibration_;
  std::vector<RawCamera> raw_;  // both cameras; empty for a rectified pair
};

}  // namespace cliquevo::drivers::sim
