// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/uncertainty.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {

// The refined solution's covariance is scaled by what its residuals show of the real noise, which the loose sigmas of
// the weights overstate, but not below a floor (what is common to all features shows in no residual), and by a factor
// that makes the normalised error right (NEES 6) on the simulator's wheeled and walking courses.
constexpr double kLeastVariance = 0.05;
constexpr double kVarianceFactor = 1.25;
constexpr double kVarianceFactorOfTwo = 0.87;  // beside a key frame, where the weights understate the previous frame
// Patches that overlap err alike: times the share of the picture that the inliers' patches would cover side by side
// (normalised error squared at 256, 384, 512 and 768 px of width, without it 7.9, 6.0, 5.3 and 3.6).
constexpr double kOverlapVariance = 1.4;
// Errors that neighbours share (of the calibration, of a surface) do not average out where all inliers come from one
// part of the picture: the variance grows with the square of what is missing.
constexpr double kLeastCovered = 0.1;
constexpr double kEvenLight = 15.0;  // grey levels by which light may change unevenly before it counts
constexpr double kHalfKnown = 1.0;   // ratio of the check on uncertainty at which the quality is 50

double noise_factor(const Findings& f, bool beside_key, const VoParams& params) {
  const double residual = f.motion.error_px / params.sigma_px;  // two of the three components: disparity is loose
  return (beside_key ? kVarianceFactorOfTwo : kVarianceFactor) * std::max(kLeastVariance, 0.5 * residual * residual);
}

double overlap_factor(const Findings& f, const VoParams& params) {
  const double side_px = 2.0 * params.refine_radius_px + 3.0;
  const double picture = static_cast<double>(f.model.width) * f.model.height;
  return 1.0 + kOverlapVariance * f.motion.inliers * side_px * side_px / picture;
}

double coverage_factor(const Findings& f) {
  const double covered = std::max(f.covered, kLeastCovered);
  return 1.0 / (covered * covered);
}

double light_factor(const Findings& f, std::vector<float>& scratch) {
  const double light = change_of_light(f.observations, scratch) / kEvenLight;
  return 1.0 + light * light;
}

}  // namespace

Matrix6d uncertainty(const Findings& f, bool beside_key, const VoParams& params, const SelfCheck& check,
                     std::vector<float>& scratch) {
  Matrix6d covariance = f.motion.covariance;
  if (!params.refine) return covariance;
  covariance *= noise_factor(f, beside_key, params);
  covariance *= overlap_factor(f, params);
  covariance *= coverage_factor(f);
  covariance *= light_factor(f, scratch);
  covariance *= check.unsettled();
  const Vector6d& change = f.motion.offset_sensitivity;
  covariance += check.offset_variance_px2() * change * change.transpose();
  return covariance;
}

Matrix6d with_error_taken_back(const Matrix6d& covariance, const Matrix6d& before) {
  const double excess = 1.0 - (covariance.diagonal().array() / before.diagonal().array()).mean();
  return excess > 0.0 ? Matrix6d(covariance + excess * before) : covariance;
}

int quality(const Checks& checks) {
  const Evidence& known = checks[Check::uncertainty];
  if (!known.applies) return 0;
  const double ratio = known.ratio() / kHalfKnown;
  return static_cast<int>(std::lround(100.0 / (1.0 + ratio * ratio)));
}

}  // namespace cliquevo::vo
