// SPDX-License-Identifier: BSD-3-Clause
// How a small piece of surface that one camera place sees is seen from another.
#pragma once

#include "core/base/camera_model.h"
#include "core/base/rigid_transform.h"
#include "core/vo/features.h"
#include "core/vo/patch.h"
#include "core/vo/rolling_shutter.h"

namespace cliquevo::vo {

inline constexpr double kMinDisparity_px = 0.1;  // with doffs: beyond, depth means nothing
inline constexpr double kMinDepth_m = 0.05;      // nearer, or behind the camera: not seen

struct SurfacePatch {
  double u = 0.0, v = 0.0, disparity_px = 0.0;  // where its centre is seen
  Warp warp;                                    // from the reference's patch to this image
  double area = 0.0;                            // of the warp: how much larger it appears
  // Warp from this left image to this right one: its slant as seen from here.
  Warp to_right;
};

// `feature`'s surface element (its place, disparity_px and slant in the reference) from the place T_cur_ref; the warp
// is taken over `reach` px. False where it is behind the camera.
bool surface_patch(const StereoModel& model, const Feature& feature, double disparity_px,
                   const RigidTransform& T_cur_ref, double reach, SurfacePatch& out);

// T_cur_ref between the rows that see this feature, from that between the frames' stamps.
RigidTransform between_rows(const StereoModel& model, const RollingShutter& shutter, const Feature& feature,
                            double disparity_px, const RigidTransform& T_cur_ref, const Velocity& reference,
                            const Velocity& current);

}  // namespace cliquevo::vo
