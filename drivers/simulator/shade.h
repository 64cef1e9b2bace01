// SPDX-License-Identifier: BSD-3-Clause
// Grey level of the ground and of the sky along a row of the image. Compiled once for every machine and once for AVX2:
// the same operations on the same numbers, so the same bits.
#pragma once

#include <cstdint>

#include "core/base/kernel_tables.h"

namespace cliquevo::drivers::sim {

// One texture laid over the ground: texel coordinate = axis . (ground point relative to the camera) + origin.
struct GroundLayer {
  const std::uint16_t* pairs;
  float axis_u[2];
  float axis_v[2];
  float origin_u, origin_v;
  float texels_per_m;
};

struct GroundShading {
  // Ray through pixel (i, j), at depth 1, world axes: start + i * per_column + j * per_row.
  float start[3], per_column[3], per_row[3];
  GroundLayer gravel, grass;
  const std::uint32_t* brightness;  // quads on the ground's grid
  const std::uint32_t* grassiness;
  int grid_columns, grid_rows;
  float grid_per_m;
  float grid_x, grid_y;  // the camera on the grid
  float haze_begin_m, haze_per_m, haze_grey;
};

struct SkyShading {
  float start[3], per_column[3], per_row[3];
  const std::uint32_t* quads;
};

inline constexpr int kShadeBlock = 64;

// invz, above, below: 1/depth of this row and its neighbours; readable from begin - 1 to begin + kShadeBlock + 1.
// Writes out[0 .. kShadeBlock) for the pixels from `begin`.
struct ShadeKernels {
  void (*ground)(const GroundShading&, const float* invz, const float* above, const float* below, int row, int begin,
                 float* out);
  void (*sky)(const SkyShading&, int row, int begin, float* out);
};

// All tables of this build.
const KernelTables<ShadeKernels>& shade_tables();
// The one for the instruction set in force.
inline const ShadeKernels& shade_kernels() { return shade_tables().active(); }
// What AVX2 overrides, in a file of its own.
void use_avx2(ShadeKernels& kernels);

}  // namespace cliquevo::drivers::sim
