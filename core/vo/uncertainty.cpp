// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/vo/surface_patch.h"

namespace cliquevo::vo {

namespace {

// The refined solution's covariance is scaled by what its residuals show of the real noise, which the loose sigmas of
// the weights overstate, but not below a floor (what is common to all features shows in no residual), and by a factor
// that makes the normalised error right (NEES 6) on the simulator's wheeled and walking courses.
constexpr double kLeastVariance = 0.05;
constexpr double kVarianceFactor = 1.25;
constexpr double kVarianceFactorOfTwo = 0.87;  // beside a key frame, where the weights understate the previous frame
// Patches that overlap err alike: times the share that the inliers' patches, side by side, would cover of the part of
// the picture they lie in (normalised error squared at 256, 384, 512 and 768 px of width, without it 7.9, 6.0, 5.3
// and 3.6).
constexpr double kOverlapVariance = 1.4;
// Errors that neighbours share (of the calibration, of a surface) do not average out where all inliers come from one
// part of the picture: the variance grows with the square of what is missing.
constexpr double kLeastCovered = 0.1;
// How many of the patches' own contrasts (RMS) light may change unevenly before it counts. Without this factor the mean
// normalised error squared of hostile frames with a glow, clean cameras and rough, is 3 to 4 below four contrasts and 4
// to 9 above.
constexpr double kEvenLight = 6.0;
constexpr int kPartsAcross = 3;  // of the picture ...
constexpr int kPartsDown = 6;    // ... finer down, where rows may bend
constexpr int kLeastParts = 6;   // with inliers: fewer do not scatter enough to be judged
// What bends rows otherwise than a steady turn does; makes the normalised error right on the simulator's rolling
// cameras (12 to 20 without it).
constexpr double kRollingFactor = 3.0;
// Where no motion before the reference is known, its rows are straightened by the motion to be found alone: the
// reference's own speed, and how it changed, are open (first frames, and the first after a gap).
constexpr double kUnknownSpeedFactor = 3.0;
// Of the variance by surfaces that change, the fourth power of the check's ratio times this: nothing below half of what
// is allowed, where right and wrong motions are alike, and three times as much at the bound.
constexpr double kChangingGround = 1.2;
constexpr double kHalfKnown = 1.0;  // ratio of the check on uncertainty at which the quality is 50

double noise_factor(const CheckInput& f, bool beside_key, const VoParams& params) {
  const double residual = f.motion.error_px / params.sigma_px;  // two of the three components: disparity is loose
  return (beside_key ? kVarianceFactorOfTwo : kVarianceFactor) * std::max(kLeastVariance, 0.5 * residual * residual);
}

double overlap_factor(const CheckInput& f, const VoParams& params) {
  const double side_px = 2.0 * params.refine_radius_px + 3.0;
  const double part = std::max(f.covered, kLeastCovered) * f.model.width * f.model.height;
  return 1.0 + kOverlapVariance * f.motion.inliers * side_px * side_px / part;
}

double coverage_factor(const CheckInput& f) {
  const double covered = std::max(f.covered, kLeastCovered);
  return 1.0 / (covered * covered);
}

// Errors that a part of the picture shares (rows that bend, surfaces) do not average out as noise does: by how much the
// means of the inliers' errors over parts of the picture scatter more than the errors themselves let expect.
double coherence_factor(const CheckInput& f) {
  struct Part {
    double u = 0.0, v = 0.0;
    int n = 0;
  };
  std::array<Part, static_cast<std::size_t>(kPartsAcross * kPartsDown)> parts;
  double squared = 0.0;
  int inliers = 0;
  for (const Observation& o : f.observations) {
    if (!o.inlier) continue;
    const RigidTransform T_cur_ref =
        f.motion.T_prev_cur.inverse() * f.T_prev_ref[static_cast<std::size_t>(o.reference)];
    const Eigen::Vector3d seen = T_cur_ref * f.model.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    if (seen.z() < kMinDepth_m) continue;
    const Eigen::Vector3d error = o.uvd_cur - f.model.project(seen);
    const auto place = [](double px, int size_px, int count) {
      return std::clamp(static_cast<int>(px * count / size_px), 0, count - 1);
    };
    const int across = place(o.uvd_cur.x(), f.model.width, kPartsAcross);
    const int down = place(o.uvd_cur.y(), f.model.height, kPartsDown);
    Part& part = parts[static_cast<std::size_t>(down) * kPartsAcross + static_cast<std::size_t>(across)];
    part.u += error.x();
    part.v += error.y();
    ++part.n;
    squared += error.x() * error.x() + error.y() * error.y();
    ++inliers;
  }
  double of_means = 0.0;
  int filled = 0;
  for (const Part& part : parts) {
    if (part.n == 0) continue;
    of_means += (part.u * part.u + part.v * part.v) / part.n;
    ++filled;
  }
  if (filled <= kLeastParts || !(squared > 0.0)) return 1.0;
  return std::max(1.0, of_means / filled / (squared / inliers));
}

double light_factor(const CheckInput& f, std::vector<float>& scratch) {
  const double light = change_of_light(f.observations, scratch) / kEvenLight;
  return 1.0 + light * light;
}

// A rolling shutter's motion where none is known before its reference.
double speed_factor(const CheckInput& f) {
  return f.model.readout_s > 0.0 && !f.speed_known ? kUnknownSpeedFactor : 1.0;
}

// Surfaces that change almost as much as is refused may move with the features on them.
double ground_factor(const Evidence& running_ground) {
  const double ratio = kChangingGround * std::min(1.0, running_ground.ratio());
  return 1.0 + ratio * ratio * ratio * ratio;
}

}  // namespace

Matrix6d uncertainty(const CheckInput& f, bool beside_key, const VoParams& params, const SelfCheck& check,
                     std::vector<float>& scratch) {
  Matrix6d covariance = f.motion.covariance;
  if (!params.refine) return covariance;
  covariance *= noise_factor(f, beside_key, params);
  covariance *= overlap_factor(f, params);
  covariance *= coverage_factor(f);
  if (f.model.readout_s > 0.0) covariance *= kRollingFactor * coherence_factor(f);
  covariance *= light_factor(f, scratch);
  covariance *= check.unsettled();
  const Vector6d& change = f.motion.offset_sensitivity;
  covariance += check.offset_variance_px2() * change * change.transpose();
  return covariance;
}

double doubt_factor(const CheckInput& f, const CameraNoise& noise, const Evidence& running_ground) {
  double factor = noise.unsettled();
  factor *= speed_factor(f);
  factor *= ground_factor(running_ground);
  return factor;
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
