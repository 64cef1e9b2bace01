// SPDX-License-Identifier: BSD-3-Clause
// Guided tracking: with a first motion at hand, every feature of a reference is looked for where the motion puts it,
// needing no corner in the new frame; position and disparity come out to a fraction of a pixel.
#pragma once

#include <vector>

#include "core/base/camera_model.h"
#include "core/vo/frame.h"
#include "core/vo/motion.h"
#include "core/vo/patch.h"
#include "core/vo/self_check.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// Least-squares plane through the disparities around the feature: its slant.
void measure_slant(ImageView<const std::int16_t> disparity, Feature& feature);

class Tracker {
 public:
  Tracker(const StereoModel& model, const VoParams& params);

  // Replaces the block matcher's disparities of the frame's features by patch alignment between its two eyes, and
  // measures the slant of the surface around each. Features whose patches do not fit keep the block matcher's value.
  void refine_disparities(ImageView<const std::int16_t> disparity, SelfCheck& check, Frame& frame);
  // Corrects the frame's disparities and points for what is known of the calibration's errors by now.
  void compensate(const SelfCheck& check, Frame& frame) const;

  // Appends an observation for each feature of `reference`, from `first` on and before `last`, that is found in
  // `current`.
  void track(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur, int reference_index,
             std::size_t first, std::size_t last, const SelfCheck& check, std::vector<Observation>& observations) const;

 private:
  void measure_vertical(SelfCheck& check, const Frame& frame);

  StereoModel model_;
  VoParams params_;
  PatchParams patch_;
  std::size_t phase_ = 0;
};

}  // namespace cliquevo::vo
