// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/patch.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cliquevo::vo {

namespace {

constexpr float kConverged = 0.12F;  // px, the last step: what remains is a fifth of it, below what noise allows
// Differences of neighbours see less of a gradient than there is, so that steps come out too long; by this share they
// are right on average.
constexpr float kStepLength = 0.87F;
constexpr float kMinGradient =
    4.0F;  // mean squared gradient (grey levels per px)^2 a patch must have in each direction

PatchGrid make_grid(int radius) {
  PatchGrid grid{};
  grid.radius = radius;
  grid.side = 2 * radius + 3;
  grid.row = (2 * radius + kPatchLanes) / kPatchLanes * kPatchLanes;
  int i = 0;
  for (int dy = -radius - 1; dy <= radius + 1; ++dy) {
    for (int dx = -radius - 1; dx <= radius + 1; ++dx, ++i) {
      grid.dx[i] = static_cast<float>(dx);
      grid.dy[i] = static_cast<float>(dy);
    }
  }
  for (int x = 0; x < 2 * radius + 1; ++x) grid.inside[x] = 1.0F;
  return grid;
}

const PatchGrid& grid_of(int radius) {
  static const std::array<PatchGrid, kMaxPatchRadius + 1> grids = [] {
    std::array<PatchGrid, kMaxPatchRadius + 1> all{};
    for (int r = 0; r <= kMaxPatchRadius; ++r) all[static_cast<std::size_t>(r)] = make_grid(r);
    return all;
  }();
  return grids[static_cast<std::size_t>(radius)];
}

bool inside(ImageView<const std::uint8_t> image, const PatchPlace& p, int reach) {
  const float r = static_cast<float>(reach);
  const float span_x = r * (std::abs(p.xx) + std::abs(p.xy));
  const float span_y = r * (std::abs(p.yx) + std::abs(p.yy));
  return p.x - span_x >= 0.0F && p.y - span_y >= 0.0F && p.x + span_x < static_cast<float>(image.width - 3) &&
         p.y + span_y < static_cast<float>(image.height - 3);
}

}  // namespace

bool cut_template(ImageView<const std::uint8_t> image, float x, float y, int radius, Template& out) {
  const PatchGrid& grid = grid_of(radius);
  const PatchPlace place{x, y, 1.0F, 0.0F, 0.0F, 1.0F};
  if (!inside(image, place, radius + 1)) return false;
  const int whole_x = static_cast<int>(x);
  const int whole_y = static_cast<int>(y);
  const int reach = radius + 1;
  kernels().patch_cut(grid, image.row(whole_y - reach) + whole_x - reach, image.stride, x - static_cast<float>(whole_x),
                      y - static_cast<float>(whole_y), out.inner);
  out.radius = radius;
  return true;
}

PatchFit fit_patch(const Template& reference, ImageView<const std::uint8_t> image, float x, float y, const Warp& warp,
                   SearchAxes axes, const PatchParams& params) {
  PatchFit fit;
  const Kernels& k = kernels();
  const int r = reference.radius;
  const PatchGrid& grid = grid_of(r);
  const float n = static_cast<float>((2 * r + 1) * (2 * r + 1));
  const float start_x = x;
  const float start_y = y;
  const float tt = reference.inner.tt;
  const float per_n = 1.0F / n;
  if (!(tt > n)) return fit;  // no contrast at all
  const float per_tt = 1.0F / tt;
  const float max_shift2 = static_cast<float>(params.max_shift_px * params.max_shift_px);
  for (int iteration = 0; iteration < params.iterations; ++iteration) {
    const PatchPlace place{x, y, warp.xx, warp.xy, warp.yx, warp.yy};
    if (!inside(image, place, r + 1)) return fit;
    // Least squares for W + Gx sx + Gy sy = gain T + bias, where G is the mean gradient of T and W (the second-order
    // step) and T is without its mean.
    PatchSums s{};
    const auto sums = axes == SearchAxes::both ? k.patch_sums : k.patch_sums_across;
    sums(grid, image.data, image.stride, place, reference.inner, s);
    // Take out the bias (means), then the gain.
    const float ww = s.ww - s.w * s.w * per_n;
    const float gain = s.tw * per_tt;
    fit.correlation = ww > 0.0F ? s.tw / std::sqrt(tt * ww) : 0.0F;
    if (!(gain > 0.3F && gain < 3.0F)) return fit;
    const float gxx = s.gxx - s.gx * s.gx * per_n - s.gxt * s.gxt * per_tt;
    const float gxy = s.gxy - s.gx * s.gy * per_n - s.gxt * s.gyt * per_tt;
    const float gyy = s.gyy - s.gy * s.gy * per_n - s.gyt * s.gyt * per_tt;
    const float gxw = s.gxw - s.gx * s.w * per_n - s.gxt * gain;
    const float gyw = s.gyw - s.gy * s.w * per_n - s.gyt * gain;
    const float sse = ww - s.tw * gain;
    float sx = 0.0F;
    float sy = 0.0F;
    if (axes == SearchAxes::row_only) {
      if (!(gxx > kMinGradient * n)) return fit;
      sx = -gxw / gxx;
    } else {
      const float determinant = gxx * gyy - gxy * gxy;
      const float trace = gxx + gyy;
      // smaller eigenvalue of the gradient matrix, from below: determinant / trace
      if (!(determinant > kMinGradient * n * trace)) return fit;
      const float per_determinant = 1.0F / determinant;
      sx = (gxy * gyw - gyy * gxw) * per_determinant;
      sy = (gxy * gxw - gxx * gyw) * per_determinant;
    }
    const float sse_there = std::max(0.0F, sse + sx * gxw + sy * gyw);  // where the step leads, as far as it is linear
    sx *= kStepLength;
    sy *= kStepLength;
    x += warp.xx * sx + warp.xy * sy;
    y += warp.yx * sx + warp.yy * sy;
    if (axes == SearchAxes::row_only) y = start_y;
    const float shift2 = (x - start_x) * (x - start_x) + (y - start_y) * (y - start_y);
    if (!(shift2 <= max_shift2)) return fit;
    fit.residual = std::sqrt(std::max(0.0F, sse) * per_n);
    if (sx * sx + sy * sy < kConverged * kConverged) {
      fit.brighter = s.w / std::sqrt(tt * n);
      fit.correlation = std::sqrt(std::max(0.0F, 1.0F - sse_there / ww));
      fit.ok = fit.residual <= static_cast<float>(params.max_residual) ||
               fit.correlation >= static_cast<float>(params.min_correlation);
      break;
    }
  }
  fit.x = x;
  fit.y = y;
  return fit;
}

}  // namespace cliquevo::vo
