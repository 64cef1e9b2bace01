// SPDX-License-Identifier: BSD-3-Clause
// Remaining errors of the rectification, estimated from ordinary driving: the vertical error as a function of the place
// in the image (from features matched between left and right), and an error common to all disparities (from the
// residuals of the motion). Needs no target, no stop and no known scene.
#pragma once

#include <array>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/vo/calibration_check.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

class SelfCheck {
 public:
  SelfCheck(const StereoModel& model, const VoParams& params);

  // One feature: where it is in the left image, and how many rows lower it is in the right one. Taken in by the next
  // update_vertical(), so that the order within a frame does not matter.
  void add_vertical(double u_px, double v_px, double error_px);
  void update_vertical();
  // What one frame's motion shows of the disparities as they are used: too large by `residual_px`, with its inverse
  // variance by noise alone.
  void add_offset(double residual_px, double information);
  void reset();
  int frames() const { return frames_; }

  // Rows by which a place of the left image is expected lower in the right one. Patches are looked for there in any
  // case; rows are never turned into disparities.
  double vertical_error_px(double u_px, double v_px) const;
  // What the odometry takes off a measured disparity; 0 unless it compensates.
  double disparity_error_px(double u_px, double v_px) const;
  // How uncertain disparities remain as they are used.
  double offset_variance_px2() const;
  // By how much a motion's covariance grows while the calibration is still being learned, and with rows that are far
  // off, which a correction removes only in part; 1 when it is settled and small.
  double unsettled() const;
  CalibrationCheck result() const;

 private:
  static constexpr int kTerms = 6;  // 1, x, y, x y, x^2, y^2 in normalised image coordinates
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using TermsMatrix = Eigen::Matrix<double, kTerms, kTerms>;
  static constexpr int kPlaces = 8;  // parts of the image, in each direction
  Terms terms(double u_px, double v_px) const;
  std::size_t place_of(double u_px, double v_px) const;

  StereoModel model_;
  bool compensate_ = true;
  TermsMatrix information_ = TermsMatrix::Zero();  // of the vertical error's coefficients, 1 / px^2
  Terms weighted_ = Terms::Zero();
  Terms vertical_ = Terms::Zero();  // the coefficients, px
  TermsMatrix fresh_information_ = TermsMatrix::Zero();
  Terms fresh_weighted_ = Terms::Zero();
  int fresh_ = 0;
  double offset_px_ = 0.0;
  double offset_variance_ = 0.0;
  double settled_px_ = 0.0;                       // running mean of the offset
  std::array<double, kPlaces * kPlaces> seen_{};  // features of late
  double recent_px_ = 0.0;                        // running mean of what remains after correction
  int frames_ = 0;
};

}  // namespace cliquevo::vo
