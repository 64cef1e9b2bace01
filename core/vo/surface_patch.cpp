// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/surface_patch.h"

#include <algorithm>

namespace cliquevo::vo {

bool surface_patch(const StereoModel& model, const Feature& f, double disparity_px, const RigidTransform& T_cur_ref,
                   double reach, SurfacePatch& out) {
  const double d = std::max(disparity_px + model.doffs_px, kMinDisparity_px);
  const Eigen::Vector3d centre = T_cur_ref * model.triangulate(f.x, f.y, d - model.doffs_px);
  if (centre.z() < kMinDepth_m) return false;
  // Two more of its points, moved likewise.
  const double right_d = std::max(d + reach * f.disparity_dx, kMinDisparity_px);
  const double below_d = std::max(d + reach * f.disparity_dy, kMinDisparity_px);
  const Eigen::Vector3d right = T_cur_ref * model.triangulate(f.x + reach, f.y, right_d - model.doffs_px);
  const Eigen::Vector3d below = T_cur_ref * model.triangulate(f.x, f.y + reach, below_d - model.doffs_px);
  if (right.z() < kMinDepth_m || below.z() < kMinDepth_m) return false;
  const Eigen::Vector3d at = model.project(centre);
  const Eigen::Vector3d across = (model.project(right) - at) / reach;
  const Eigen::Vector3d down = (model.project(below) - at) / reach;
  out.u = at.x(), out.v = at.y(), out.disparity_px = at.z();
  out.area = across.x() * down.y() - across.y() * down.x();
  out.warp.xx = static_cast<float>(across.x());
  out.warp.yx = static_cast<float>(across.y());
  out.warp.xy = static_cast<float>(down.x());
  out.warp.yy = static_cast<float>(down.y());
  // Gradient of the disparity in the new image = (its changes over the two steps) * A^-1.
  out.to_right = {};
  out.to_right.xx = static_cast<float>(1.0 - (across.z() * down.y() - down.z() * across.y()) / out.area);
  out.to_right.xy = static_cast<float>(-(down.z() * across.x() - across.z() * down.x()) / out.area);
  return true;
}

RigidTransform between_rows(const StereoModel& model, const RollingShutter& shutter, const Feature& f,
                            double disparity_px, const RigidTransform& T_cur_ref, const Velocity& reference,
                            const Velocity& current) {
  const double d = std::max(disparity_px + model.doffs_px, kMinDisparity_px);
  RigidTransform T_cur_row = T_cur_ref * shutter.T_stamp_row(reference, f.y);
  const Eigen::Vector3d seen = T_cur_row * model.triangulate(f.x, f.y, d - model.doffs_px);
  if (seen.z() < kMinDepth_m) return T_cur_row;
  const double row = std::clamp(model.project(seen).y(), 0.0, model.height - 1.0);
  return shutter.T_stamp_row(current, row).inverse() * T_cur_row;
}

}  // namespace cliquevo::vo
