// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/noise.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {

constexpr double kMemory = 60.0;          // frames
constexpr double kErrorPerScatter = 1.5;  // the same patches over time, beside left and right at once
constexpr double kFirstScatter_px = 0.1;  // before anything was measured
constexpr double kFirstShift_px = 0.15;   // of a camera of which nothing is known, worth so many frames:
constexpr double kFirstFrames = 5.0;
constexpr double kStiffShift_px = 0.02;       // no rig is stiffer
constexpr double kShiftModelError_px = 0.12;  // of one frame's reading, beside its noise: surfaces, interpolation
constexpr double kDeflation = 4.0;            // neighbouring patches err alike: a reading knows less than it seems
constexpr double kTellingVariance = 0.05;     // px^2: readings that know less count less
constexpr double kMostShift_px = 3.0;         // a larger one is no flexing rig
constexpr double kNewsOfThisFrame = 9.0;      // variances from which on a frame's own reading widens the prior
// Without it the normalised error squared of a first motion is 8 in hostile cases, of the second 5, of later ones 3
// to 4.
constexpr double kUnsettled = 2.0;  // of a first motion's variance beyond a settled one's
constexpr double kRowNoise = 0.04;  // px, of a frame's median row

double reading_variance(const Motion& motion) {
  return kShiftModelError_px * kShiftModelError_px + kDeflation / motion.shift_information;
}

}  // namespace

void CameraNoise::reset() {
  row_scatter_px_ = kFirstScatter_px;
  row_shift_variance_ = 0.0;
  grey_levels_ = 0.0;
  views_ = 0.0;
  shift_variance_ = kFirstShift_px * kFirstShift_px;
  motions_ = kFirstFrames;
  valid_ = 0;
}

void CameraNoise::add_views(const Frame& frame) {
  if (!(frame.row_scatter_px > 0.0)) return;
  views_ = std::min(kMemory, views_ + 1.0);
  const double share = 1.0 / views_;
  row_scatter_px_ += share * (frame.row_scatter_px - row_scatter_px_);
  grey_levels_ += share * (frame.grey_scatter - grey_levels_);
  row_shift_variance_ += share * (frame.row_shift_px * frame.row_shift_px - row_shift_variance_);
}

void CameraNoise::add_motion(const Motion& motion) {
  ++valid_;
  if (!(motion.shift_information > 0.0) || !std::isfinite(motion.free_shift_px)) return;
  const double reading = std::clamp(motion.free_shift_px, -kMostShift_px, kMostShift_px);
  const double variance = reading_variance(motion);
  const double weight = std::min(1.0, kTellingVariance / variance);
  motions_ = std::min(kMemory, motions_ + weight);
  shift_variance_ += weight / motions_ * (reading * reading - variance - shift_variance_);
}

double CameraNoise::expected_error_px() const {
  const double scattered = kErrorPerScatter * row_scatter_px_;
  return std::sqrt(kAlignmentError_px * kAlignmentError_px + scattered * scattered);
}

double CameraNoise::shift_sigma_px() const {
  return std::max(kStiffShift_px, std::sqrt(std::max(0.0, shift_variance_)));
}

double CameraNoise::shift_sigma_px(const Motion& first) const {
  const double learned = shift_sigma_px();
  return shift_news(first) > kNewsOfThisFrame ? std::max(learned, std::abs(first.free_shift_px)) : learned;
}

double CameraNoise::shift_news(const Motion& motion) const {
  if (!(motion.shift_information > 0.0)) return 0.0;
  const double sigma = shift_sigma_px();
  return motion.free_shift_px * motion.free_shift_px / (sigma * sigma + reading_variance(motion));
}

double CameraNoise::unsettled() const {
  const double motions = 1.0 + valid_;
  return 1.0 + kUnsettled / (motions * motions);
}

double CameraNoise::row_shift_px(const Frame& frame) const {
  const double excess = std::max(0.0, row_shift_variance_ - kRowNoise * kRowNoise);
  return frame.row_shift_px * excess / (excess + kRowNoise * kRowNoise);
}

}  // namespace cliquevo::vo
