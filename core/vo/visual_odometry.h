// SPDX-License-Identifier: BSD-3-Clause
// Howard's stereo visual odometry (IROS 2008): two frames in, one rigid transform, its covariance and a verdict out.
#pragma once

#include <memory>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/movers.h"
#include "core/vo/self_check.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// Step A1. All views have the size of the StereoModel and stay valid during process() only.
struct FrameInput {
  TimestampNs stamp_ns = 0;
  ImageView<const std::uint8_t> left;           // rectified
  ImageView<const std::uint8_t> right;          // rectified
  ImageView<const std::uint8_t> filtered_left;  // the paper's J
  ImageView<const std::int16_t> disparity;      // px * 16, kUnknownDisparity where unknown
};

// The verdict on a frame; the numbers go out over LCM.
enum class Status : std::int8_t {
  no_data = 0,             // first frame: nothing to compare with
  valid = 1,               //
  too_few_features = 2,    // features, matches or clique too small
  degenerate = 3,          // spread of the inliers too one-sided to fix the motion
  reprojection_error = 4,  // the inliers do not agree on one motion
  ambiguous = 5,           // a second motion is well supported, or much of the picture speaks against the one found
};
const char* status_name(Status status);

// Time spent in each step of the last frame.
struct StepTimes {
  std::int64_t features_ns = 0;
  std::int64_t scores_ns = 0;
  std::int64_t matches_ns = 0;
  std::int64_t clique_ns = 0;
  std::int64_t motion_ns = 0;
  std::int64_t total_ns = 0;
};

// Step A7. `T_prev_cur` takes points of this camera frame to the last valid frame's one (`prev_stamp_ns`): after failed
// frames the next valid estimate spans the gap. On failure it is the identity, the covariance is large, and only the
// pose moves on by the stated guess.
struct Estimate {
  Status status = Status::no_data;
  TimestampNs stamp_ns = 0;
  TimestampNs prev_stamp_ns = 0;
  RigidTransform T_prev_cur;
  // Of [translation m, rotation vector rad], perturbing T_prev_cur on the left (see perturb_left).
  Matrix6d covariance = Matrix6d::Identity();
  RigidTransform T_world_camera;  // pose in the first frame; carries the guess after a failure
  int features = 0;
  int matches = 0;                     // co-occurring minima
  int clique = 0;                      // size of the greedy clique
  int inliers = 0;                     // that the final solution rests on
  double reprojection_error_px = 0.0;  // RMS over the inliers
  double eigenvalue_ratio = 0.0;       // spread of the inliers in the image, 0 (a line) to 1 (round)
  // What speaks against the motion even where all inliers agree: the share of the picture's cells whose texture is not
  // where the motion puts it, and how much the picture changed more than two views of one moment differ.
  double contradiction = 0.0;
  double unsteadiness_px = 0.0;
  // What this frame alone says of an error common to all disparities, as compensated: how much too large, and the
  // inverse variance of that figure by noise alone (0: says nothing).
  double disparity_offset_px = 0.0;
  double disparity_offset_information = 0.0;
  CalibrationCheck calibration;  // what is known of its errors up to this frame
  VehiclePart vehicle_part;      // noticed in the view up to this frame
  StepTimes times;
};

class VisualOdometry {
 public:
  static Result<VisualOdometry> make(const StereoModel& model, const VoParams& params);
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;
  ~VisualOdometry();

  // mask: model-sized, 0 = no features here (the vehicle's own parts). Empty view = none.
  Result<void> set_mask(ImageView<const std::uint8_t> left_mask);
  // One frame. An Error means unusable input (empty or wrongly sized views, a stamp that does not advance): the state
  // is as before the call. Everything else is a verdict in the estimate. Allocates nothing after the first frames.
  Result<void> process(const FrameInput& frame);
  const Estimate& estimate() const;
  // What else moved in the last frame.
  const Movers& movers() const;
  // Forget all frames and start again at the identity.
  void reset();

 private:
  struct Impl;
  explicit VisualOdometry(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::vo
