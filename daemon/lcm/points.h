// SPDX-License-Identifier: BSD-3-Clause
// Points of a disparity image: what VO_POINTS sends.
#pragma once

#include <cliquevo/points_t.hpp>

#include "core/base/camera_model.h"
#include "core/base/rigid_transform.h"
#include "daemon/lcm/image_tap.h"

namespace cliquevo::daemon {

// Standard deviation of one pixel's disparity, px (tests/system/points_test.cpp holds it against the simulator's
// truth).
inline constexpr double kDisparitySigma_px = 0.4;

// One point of each square of step_px pixels of which at least half are known: that of the median disparity, so it lies
// on a surface, also where two meet. Left out are those whose sigma would be above a quarter of their depth. Every
// number is finite. Allocates while it grows.
void build_points(const TappedImages& images, const StereoModel& model, const RigidTransform& T_body_camera,
                  int step_px, points_t& out);

}  // namespace cliquevo::daemon
