// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/patch.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace cliquevo::vo {

namespace {

constexpr float kConverged = 0.01F;  // px: far below what noise allows
constexpr float kMinGradient =
    4.0F;  // mean squared gradient (grey levels per px)^2 a patch must have in each direction

// Bilinear samples on the warped grid around (x, y); false when one would lie outside.
bool sample_patch(ImageView<const std::uint8_t> image, float x, float y, const Warp& w, int reach, float* out) {
  const float r = static_cast<float>(reach);
  const float span_x = r * (std::abs(w.xx) + std::abs(w.xy));
  const float span_y = r * (std::abs(w.yx) + std::abs(w.yy));
  if (!(x - span_x >= 0.0F && y - span_y >= 0.0F && x + span_x < static_cast<float>(image.width - 1) &&
        y + span_y < static_cast<float>(image.height - 1))) {
    return false;
  }
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const float fx = x + w.xx * static_cast<float>(dx) + w.xy * static_cast<float>(dy);
      const float fy = y + w.yx * static_cast<float>(dx) + w.yy * static_cast<float>(dy);
      const int ix = static_cast<int>(fx);
      const int iy = static_cast<int>(fy);
      const float ax = fx - static_cast<float>(ix);
      const float ay = fy - static_cast<float>(iy);
      const std::uint8_t* p = image.row(iy) + ix;
      const std::uint8_t* q = p + image.stride;
      const float top = static_cast<float>(p[0]) + ax * static_cast<float>(p[1] - p[0]);
      const float bottom = static_cast<float>(q[0]) + ax * static_cast<float>(q[1] - q[0]);
      *out++ = top + ay * (bottom - top);
    }
  }
  return true;
}

}  // namespace

bool cut_template(ImageView<const std::uint8_t> image, float x, float y, int radius, Template& out) {
  out.radius = radius;
  return sample_patch(image, x, y, {}, radius + 1, out.samples);
}

PatchFit fit_patch(const Template& reference, ImageView<const std::uint8_t> image, float x, float y, const Warp& warp,
                   Freedom freedom, const PatchParams& params) {
  PatchFit fit;
  const int r = reference.radius;
  const int side = 2 * (r + 1) + 1;
  const float n = static_cast<float>((2 * r + 1) * (2 * r + 1));
  float warped[kMaxPatchSide * kMaxPatchSide];
  const float start_x = x;
  const float start_y = y;
  const float max_shift2 = static_cast<float>(params.max_shift_px * params.max_shift_px);
  for (int iteration = 0; iteration < params.iterations; ++iteration) {
    if (!sample_patch(image, x, y, warp, r + 1, warped)) return fit;
    // Least squares for W + Gx sx + Gy sy = gain T + bias, where G is the mean gradient of T and W (the second-order
    // step). Sums over the patch:
    float t = 0, w = 0, gx = 0, gy = 0, tt = 0, tw = 0, ww = 0;
    float gxx = 0, gxy = 0, gyy = 0, gxt = 0, gyt = 0, gxw = 0, gyw = 0;
    for (int i = 1; i < side - 1; ++i) {
      const float* T = reference.samples + i * side;
      const float* W = warped + i * side;
      for (int j = 1; j < side - 1; ++j) {
        const float gxj = 0.25F * (T[j + 1] - T[j - 1] + W[j + 1] - W[j - 1]);
        const float gyj = 0.25F * (T[j + side] - T[j - side] + W[j + side] - W[j - side]);
        t += T[j];
        w += W[j];
        gx += gxj;
        gy += gyj;
        tt += T[j] * T[j];
        tw += T[j] * W[j];
        ww += W[j] * W[j];
        gxx += gxj * gxj;
        gxy += gxj * gyj;
        gyy += gyj * gyj;
        gxt += gxj * T[j];
        gyt += gyj * T[j];
        gxw += gxj * W[j];
        gyw += gyj * W[j];
      }
    }
    // Take out the bias (means), then the gain.
    tt -= t * t / n;
    tw -= t * w / n;
    ww -= w * w / n;
    gxx -= gx * gx / n;
    gxy -= gx * gy / n;
    gyy -= gy * gy / n;
    gxt -= gx * t / n;
    gyt -= gy * t / n;
    gxw -= gx * w / n;
    gyw -= gy * w / n;
    if (!(tt > n)) return fit;  // no contrast at all
    const float gain = tw / tt;
    if (!(gain > 0.3F && gain < 3.0F)) return fit;
    gxx -= gxt * gxt / tt;
    gxy -= gxt * gyt / tt;
    gyy -= gyt * gyt / tt;
    gxw -= gxt * gain;
    gyw -= gyt * gain;
    const float sse = ww - tw * gain;
    float sx = 0.0F;
    float sy = 0.0F;
    if (freedom == Freedom::row_only) {
      if (!(gxx > kMinGradient * n)) return fit;
      sx = -gxw / gxx;
    } else {
      const float determinant = gxx * gyy - gxy * gxy;
      const float trace = gxx + gyy;
      // smaller eigenvalue of the gradient matrix, from below: determinant / trace
      if (!(determinant > kMinGradient * n * trace)) return fit;
      sx = -(gyy * gxw - gxy * gyw) / determinant;
      sy = -(gxx * gyw - gxy * gxw) / determinant;
    }
    x += warp.xx * sx + warp.xy * sy;
    y += warp.yx * sx + warp.yy * sy;
    if (freedom == Freedom::row_only) y = start_y;
    const float shift2 = (x - start_x) * (x - start_x) + (y - start_y) * (y - start_y);
    if (!(shift2 <= max_shift2)) return fit;
    fit.residual = std::sqrt(std::max(0.0F, sse) / n);
    if (sx * sx + sy * sy < kConverged * kConverged) {
      fit.ok = fit.residual <= static_cast<float>(params.max_residual);
      break;
    }
  }
  fit.x = x;
  fit.y = y;
  return fit;
}

}  // namespace cliquevo::vo
