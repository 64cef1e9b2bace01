// SPDX-License-Identifier: BSD-3-Clause
// Howard's stereo visual odometry (IROS 2008): two frames in, one rigid transform, its covariance and a verdict out.
#pragma once

#include <memory>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/calibration_check.h"
#include "core/vo/evidence.h"
#include "core/vo/movers.h"
#include "core/vo/seen_feature.h"
#include "core/vo/step_times.h"
#include "core/vo/verdict.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// Step A1. All views have the size of the StereoModel and stay valid during process() only.
struct FrameInput {
  TimestampNs stamp_ns = 0;                     // of the exposure; rises
  ImageView<const std::uint8_t> left;           // rectified
  ImageView<const std::uint8_t> right;          // rectified
  ImageView<const std::uint8_t> filtered_left;  // the paper's J
  ImageView<const std::int16_t> disparity;      // px * 16, kUnknownDisparity where unknown
};

// Step A7. `T_prev_cur` takes points of this camera frame to the last valid frame's one (`prev_stamp_ns`): after failed
// frames the next valid estimate spans the gap. On failure it is the identity, the covariance is large, and only the
// pose moves on by the stated guess.
struct Estimate {
  Status status = Status::no_data;  // the verdict
  TimestampNs stamp_ns = 0;         // of this frame
  TimestampNs prev_stamp_ns = 0;    // of the last valid frame
  RigidTransform T_prev_cur;        // motion since then
  // Of [translation m, rotation vector rad], perturbing T_prev_cur on the left (see perturb_left).
  Matrix6d covariance = Matrix6d::Identity();
  RigidTransform T_world_camera;       // pose in the first frame; carries the guess after a failure
  int features = 0;                    // corners with known depth
  int matches = 0;                     // co-occurring minima
  int clique = 0;                      // size of the greedy clique
  int inliers = 0;                     // that the final solution rests on
  double reprojection_error_px = 0.0;  // RMS over the inliers
  double eigenvalue_ratio = 0.0;       // spread of the inliers in the image, 0 (a line) to 1 (round)
  Checks checks;                       // each check's value beside its bound: why a frame failed
  int quality = 0;                     // 0 to 100, from the covariance; 0 on failure
  // What this frame alone shows of an error common to all disparities, as compensated: how much too large, and the
  // inverse variance of that figure by noise alone (0: nothing).
  double disparity_offset_px = 0.0;
  double disparity_offset_information = 0.0;  // 1 / px^2
  // By how much this frame's disparities alone were found too large (a rig that flexes), and the camera's usual width
  // of that; the reprojection error that its measured noise makes expected.
  double disparity_shift_px = 0.0;
  double disparity_shift_sigma_px = 0.0;  // its usual width
  double expected_error_px = 0.0;         // reprojection error
  CalibrationCheck calibration;           // what is known of its errors up to this frame
  VehiclePart vehicle_part;               // found in the view up to this frame
  StepTimes times;                        // where the time went
};

// From rectified pairs with their disparity to poses. One thread at a time.
class VisualOdometry {
 public:
  // Fails on a model or parameters that cannot be.
  static Result<VisualOdometry> make(const StereoModel& model, const VoParams& params);
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;
  ~VisualOdometry();

  // mask: model-sized, 0 = no features here (the vehicle's own parts). Empty view = none.
  Result<void> set_mask(ImageView<const std::uint8_t> left_mask);
  // One frame. An Error means unusable input (empty or wrongly sized views, a stamp that does not advance): the state
  // is as before the call. Everything else is a verdict in the estimate. Allocates nothing after the first frames.
  Result<void> process(const FrameInput& frame);
  // Of the last process().
  const Estimate& estimate() const;
  // What else moved in the last frame.
  const Movers& movers() const;
  // What became of the last frame's features, as the last attempt at its motion left them.
  void list_features(std::vector<SeenFeature>& out) const;
  // Forget all frames and start again at the identity.
  void reset();

 private:
  struct Impl;
  explicit VisualOdometry(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::vo
