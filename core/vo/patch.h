// SPDX-License-Identifier: BSD-3-Clause
// Sub-pixel alignment of image patches: efficient second-order minimisation (Malis 2004; Benhimane and Malis 2007) with
// gain and bias, so that exposure changes do not move a feature.
#pragma once

#include "core/base/image.h"
#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

// Linear part of the warp from template to image: image = centre + A * (dx, dy).
struct Warp {
  float xx = 1.0F;
  float xy = 0.0F;
  float yx = 0.0F;
  float yy = 1.0F;
};

struct PatchParams {
  int radius = 4;      // patch side 2 r + 1, r <= 7
  int iterations = 8;  // at most
  // The patches are the same where they differ by no more than this (RMS grey levels after gain and bias), or share so
  // much of their contrast: noise may be all the difference, or a small part of a strong pattern.
  double max_residual = 12.0;
  double min_correlation = 0.8;
  double max_shift_px = 4.0;  // from the start; farther is lost
};

enum class SearchAxes { row_only, both };

struct PatchFit {
  bool ok = false;
  float x = 0.0F;  // where the template's centre is in the image
  float y = 0.0F;
  float residual = 0.0F;     // RMS grey levels
  float brighter = 0.0F;     // by how many of the template's contrasts (RMS) the image is brighter there
  float correlation = 0.0F;  // of template and image, less their means, where last looked at
};

// A patch cut from an image once, to be found in others.
struct Template {
  PatchInner inner;
  int radius = 0;
};

// False when the patch does not lie inside the image.
bool cut_template(ImageView<const std::uint8_t> image, float x, float y, int radius, Template& out);

// Finds the template in `image` near (x, y). Fails (ok = false) when it leaves the image, does not converge, drifts too
// far, has no texture along the axes searched, or fits badly.
PatchFit fit_patch(const Template& reference, ImageView<const std::uint8_t> image, float x, float y, const Warp& warp,
                   SearchAxes axes, const PatchParams& params);

}  // namespace cliquevo::vo
