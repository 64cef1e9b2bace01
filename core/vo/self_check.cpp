// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/self_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Cholesky>

namespace cliquevo::vo {

namespace {

constexpr double kVerticalPrior = 1.0;   // px, each term's share of the error at the border
constexpr double kVerticalSigma = 0.15;  // px, of one feature
constexpr double kVerticalRobust = 0.4;  // px, a feature farther off counts ever less
constexpr double kSeenShare = 0.25;      // of the mean: parts of the image with fewer features are not judged
constexpr double kForget = 1.0 / 300.0;  // share of the old knowledge that a frame displaces
constexpr double kOffsetPrior = 0.5;     // px
// Consecutive frames see the same features with the same errors: a frame is worth less than its noise alone would
// allow.
constexpr double kOffsetDeflation = 4.0;
constexpr double kOffsetFrameSigma = 0.1;  // px, error of one frame's figure that its noise does not show
constexpr double kOffsetWander = 0.002;    // px a frame: calibrations drift with temperature
constexpr double kRecent = 0.2;            // share of a frame in the running mean of the innovations ...
constexpr double kTrustedVariance = 0.05;  // px^2, (less of one with a larger variance) ...
constexpr double kMostRecent = 5.0;        // px, ... to which it adds no more than this ...
constexpr double kSurprise = 2.0;          // ... and whose square, in variances, is a surprise
// While the figure still moves against its running mean, by more than the latter, less is known than it seems.
constexpr double kSettle = 0.05;   // share of a frame in the running mean
constexpr double kSettled = 0.15;  // px
constexpr double kFarOff = 2.0;    // px, of rows at the border: half of the variance is then not the noise's
constexpr double kOffsetMostInnovation = 0.5;  // px, of one frame
// What stays uncertain after any number of frames: interpolation, lenses, the model itself.
constexpr double kVerticalFloor = 0.02;  // px
constexpr double kOffsetFloor = 0.03;    // px
// An error larger than both is reported.
constexpr double kNoticeableSigmas = 4.0;
constexpr double kNoticeableOffset = 0.25;   // px
constexpr double kNoticeableVertical = 0.5;  // px
constexpr double kDegrees = 180.0 / 3.14159265358979323846;

}  // namespace

bool CalibrationCheck::noticeable() const {
  if (frames == 0) return false;
  return std::abs(disparity_offset_px) > std::max(kNoticeableOffset, kNoticeableSigmas * disparity_offset_sigma_px) ||
         vertical_most_px > std::max(kNoticeableVertical, kNoticeableSigmas * vertical_sigma_px);
}

std::string describe(const CalibrationCheck& c) {
  char text[512];
  // Without a valid motion the disparities' offset is as uncertain as before the first frame.
  constexpr double kEvidence = 0.9;
  if (c.frames == 0) return "not checked: no evidence yet";
  if (!c.noticeable()) {
    if (c.disparity_offset_sigma_px > kEvidence * kOffsetPrior) return "not checked: no evidence yet";
    std::snprintf(text, sizeof text,
                  "the calibration agrees with the images (disparities to %.2f +- %.2f px, rows to %.2f px)",
                  c.disparity_offset_px, c.disparity_offset_sigma_px, c.vertical_most_px);
    return text;
  }
  std::snprintf(
      text, sizeof text,
      "the calibration is off: disparities are %.2f +- %.2f px too %s and rows differ by up to %.2f px%s; if it "
      "is a rotation of the right camera, rotating it by %.3f %.3f %.3f deg about x y z corrects it; calibrate again",
      std::abs(c.disparity_offset_px), c.disparity_offset_sigma_px, c.disparity_offset_px > 0.0 ? "large" : "small",
      c.vertical_most_px, c.compensated ? " (the odometry corrects for it)" : "", -c.rotation_deg.x(),
      -c.rotation_deg.y(), -c.rotation_deg.z());
  return text;
}

SelfCheck::SelfCheck(const StereoModel& model, const VoParams& params)
    : model_(model), compensate_(params.compensate_calibration) {
  reset();
}

void SelfCheck::reset() {
  const Terms at_border = terms(model_.cx_px + 0.5 * model_.width, model_.cy_px + 0.5 * model_.height);
  information_ = (at_border / kVerticalPrior).cwiseAbs2().asDiagonal();
  weighted_.setZero();
  vertical_.setZero();
  fresh_information_.setZero();
  fresh_weighted_.setZero();
  fresh_ = 0;
  offset_px_ = 0.0;
  offset_variance_ = kOffsetPrior * kOffsetPrior;
  recent_px_ = 0.0;
  settled_px_ = 0.0;
  seen_.fill(0.0);
  frames_ = 0;
}

std::size_t SelfCheck::place_of(double u_px, double v_px) const {
  const int x = std::clamp(static_cast<int>(kPlaces * u_px / model_.width), 0, kPlaces - 1);
  const int y = std::clamp(static_cast<int>(kPlaces * v_px / model_.height), 0, kPlaces - 1);
  return static_cast<std::size_t>(y) * kPlaces + static_cast<std::size_t>(x);
}

SelfCheck::Terms SelfCheck::terms(double u_px, double v_px) const {
  const double x = (u_px - model_.cx_px) / model_.fx_px;
  const double y = (v_px - model_.cy_px) / model_.fy_px;
  Terms t;
  t << 1.0, x, y, x * y, x * x, y * y;
  return t;
}

void SelfCheck::add_vertical(double u_px, double v_px, double error_px) {
  const Terms t = terms(u_px, v_px);
  const double r = (error_px - t.dot(vertical_)) / kVerticalRobust;
  const double weight = 1.0 / (kVerticalSigma * kVerticalSigma * (1.0 + r * r));
  fresh_information_.noalias() += weight * t * t.transpose();
  fresh_weighted_ += weight * error_px * t;
  ++fresh_;
  seen_[place_of(u_px, v_px)] += 1.0;
}

void SelfCheck::update_vertical() {
  if (fresh_ == 0) return;
  information_ = (1.0 - kForget) * information_ + fresh_information_;
  weighted_ = (1.0 - kForget) * weighted_ + fresh_weighted_;
  for (double& seen : seen_) seen *= 1.0 - kForget;
  const Terms solved = information_.ldlt().solve(weighted_);
  if (solved.allFinite()) vertical_ = solved;
  fresh_information_.setZero();
  fresh_weighted_.setZero();
  fresh_ = 0;
  ++frames_;
}

void SelfCheck::add_offset(double residual_px, double information) {
  if (!(information > 0.0) || !std::isfinite(residual_px)) return;
  offset_variance_ += kOffsetWander * kOffsetWander;
  const double variance = kOffsetDeflation / information + kOffsetFrameSigma * kOffsetFrameSigma;
  const double innovation = compensate_ ? residual_px : residual_px - offset_px_;
  const double share = kRecent * std::min(1.0, kTrustedVariance / variance);
  recent_px_ += share * (std::clamp(innovation, -kMostRecent, kMostRecent) - recent_px_);
  // Far off what was thought possible, again and again: then less was known than thought.
  if (recent_px_ * recent_px_ > kSurprise * (offset_variance_ + variance)) offset_variance_ += recent_px_ * recent_px_;
  const double gain = offset_variance_ / (offset_variance_ + variance);
  const double most = std::max(kOffsetMostInnovation, std::abs(recent_px_));
  offset_px_ += gain * std::clamp(innovation, -most, most);
  offset_variance_ *= 1.0 - gain;
  settled_px_ += kSettle * (offset_px_ - settled_px_);
}

double SelfCheck::offset_variance_px2() const {
  const double left = compensate_ ? 0.0 : offset_px_;
  return offset_variance_ + recent_px_ * recent_px_ + left * left;
}

double SelfCheck::unsettled() const {
  const double trend = (offset_px_ - settled_px_) / kSettled;
  const double rows_px = std::abs(vertical_[0]) + std::abs(vertical_[1]) * 0.5 * model_.width / model_.fx_px +
                         std::abs(vertical_[2]) * 0.5 * model_.height / model_.fy_px;
  const double far_off = rows_px / kFarOff;
  return 1.0 + trend * trend + far_off * far_off;
}

double SelfCheck::vertical_error_px(double u_px, double v_px) const { return terms(u_px, v_px).dot(vertical_); }

double SelfCheck::disparity_error_px(double u_px, double v_px) const {
  if (!compensate_) return 0.0;
  // A turn of the right camera about its y, z and x axes.
  const double x = (u_px - model_.cx_px) / model_.fx_px;
  const double y = (v_px - model_.cy_px) / model_.fy_px;
  return offset_px_ * (1.0 + x * x) + y * vertical_[1] - x * y * vertical_[0];
}

CalibrationCheck SelfCheck::result() const {
  CalibrationCheck c;
  c.frames = frames_;
  c.compensated = compensate_;
  c.vertical_px = vertical_[0];
  c.vertical_across_px = vertical_[1] * model_.width / model_.fx_px;
  c.vertical_down_px = vertical_[2] * model_.height / model_.fy_px;
  double least = 0.0;
  for (const double seen : seen_) least += kSeenShare / (kPlaces * kPlaces) * seen;
  for (int k = 0; k < kPlaces * kPlaces; ++k) {
    if (!(seen_[static_cast<std::size_t>(k)] > least)) continue;
    const double u = (k % kPlaces + 0.5) * model_.width / kPlaces;
    const double v = (k / kPlaces + 0.5) * model_.height / kPlaces;  // NOLINT(bugprone-integer-division): a row
    c.vertical_most_px = std::max(c.vertical_most_px, std::abs(vertical_error_px(u, v)));
  }
  const TermsMatrix covariance = information_.ldlt().solve(TermsMatrix::Identity());
  c.vertical_sigma_px = std::sqrt(covariance(0, 0) + kVerticalFloor * kVerticalFloor);
  c.disparity_offset_px = offset_px_;
  c.disparity_offset_sigma_px = std::sqrt(offset_variance_ + kOffsetFloor * kOffsetFloor);
  const double across = 0.25 * model_.width / model_.fx_px;  // where features are, on average
  const double slope_floor = kVerticalFloor / across;
  c.rotation_deg =
      Eigen::Vector3d(vertical_[0] / model_.fy_px, offset_px_ / model_.fx_px, -vertical_[1] / model_.fy_px);
  c.rotation_deg *= kDegrees;
  c.rotation_sigma_deg = Eigen::Vector3d(c.vertical_sigma_px / model_.fy_px, c.disparity_offset_sigma_px / model_.fx_px,
                                         std::sqrt(covariance(1, 1) + slope_floor * slope_floor) / model_.fy_px);
  c.rotation_sigma_deg *= kDegrees;
  const double down_floor = kVerticalFloor * model_.fy_px / (0.25 * model_.height);
  c.focal_ratio_error = vertical_[2] / model_.fy_px;
  c.focal_ratio_sigma = std::sqrt(covariance(2, 2) + down_floor * down_floor) / model_.fy_px;
  return c;
}

}  // namespace cliquevo::vo
