// SPDX-License-Identifier: BSD-3-Clause
// Lists what became of the last frame's features.
#pragma once

#include <vector>

#include "core/base/camera_model.h"
#include "core/vo/frame.h"
#include "core/vo/motion.h"
#include "core/vo/movers.h"
#include "core/vo/seen_feature.h"

namespace cliquevo::vo {

// What the last comparison of a frame left behind; null pointers where there was none.
struct Seen {
  const StereoModel& model;
  const Frame* current;
  const Frame* reference;
  const std::vector<Observation>* observations;
  const RigidTransform& T_ref_cur;
  const Movers& movers;
};

// Allocates while `out` grows to what max_features makes possible, not afterwards.
void list_seen(const Seen& seen, std::vector<SeenFeature>& out);

}  // namespace cliquevo::vo
