// SPDX-License-Identifier: BSD-3-Clause
// Guided tracking: with a first motion at hand, every feature of a reference is looked for where the motion puts it,
// needing no corner in the new frame; position and disparity come out to a fraction of a pixel.
#pragma once

#include <limits>
#include <vector>

#include "core/base/camera_model.h"
#include "core/vo/frame.h"
#include "core/vo/motion.h"
#include "core/vo/patch.h"
#include "core/vo/self_check.h"
#include "core/vo/surface_patch.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// Least-squares plane through the disparities around the feature: its slant.
void measure_slant(ImageView<const std::int16_t> disparity, Feature& feature);

// What is taken off the measurements between a frame's left and right image: the calibration's error, and the frame's
// own (a rig that flexes).
struct ViewErrors {
  const SelfCheck& check;
  double shift_px = 0.0;  // of all disparities
  double row_px = 0.0;    // of all rows of the right image
  // Rolling shutters only: how fast the reference and the current camera move.
  Velocity reference_velocity = Velocity::Zero();
  Velocity velocity = Velocity::Zero();
  double disparity_px(double u_px, double v_px) const { return check.disparity_error_px(u_px, v_px) + shift_px; }
  double rows_px(double u_px, double v_px) const { return check.vertical_error_px(u_px, v_px) + row_px; }
};

// Blurred and small pictures have too little in a patch of the usual size.
enum class PatchSize { usual, large };

// Which features of a reference: from `first` on and before `last`.
struct FeatureRange {
  std::size_t first = 0;
  std::size_t last = std::numeric_limits<std::size_t>::max();
};

class Tracker {
 public:
  Tracker(const StereoModel& model, const VoParams& params);

  // Between the frame's left and right image: row shift, scatter and difference of grey levels (written to the frame),
  // rows for the self-check, and the slant of the surface around each feature.
  void measure_views(ImageView<const std::int16_t> disparity, SelfCheck& check, Frame& frame);
  // Replaces the block matcher's disparities of the frame's features by patch alignment between left and right image.
  // Features whose patches do not fit keep the block matcher's value.
  void refine_disparities(const ViewErrors& errors, Frame& frame) const;
  // Corrects the frame's disparities and points for what is known of their errors by now.
  void compensate(const SelfCheck& check, Frame& frame) const;

  // Patches that differ by less than this are the same, grey levels RMS: what the camera's noise was measured to allow.
  void set_noise(double grey_levels);

  // Appends an observation for each of these features of `reference` that is found in `current`.
  void track(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur, int reference_index,
             const FeatureRange& range, PatchSize size, const ViewErrors& errors,
             std::vector<Observation>& observations) const;

 private:
  bool find(const Frame& reference, const Frame& current, const Feature& feature, const SurfacePatch& expected,
            const PatchParams& patch, const ViewErrors& errors, Observation& out) const;

  StereoModel model_;
  RollingShutter shutter_;
  VoParams params_;
  PatchParams patch_;
  PatchParams large_patch_;
  std::size_t phase_ = 0;
  std::vector<double> rows_;
  std::vector<double> greys_;
};

}  // namespace cliquevo::vo
