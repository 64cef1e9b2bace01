// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/validation.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {
constexpr double kLeastDifference = 0.01;  // of correlations: where both hardly differ, the ratio says nothing
constexpr double kOffsetNoise = 0.15;      // px, of one frame's figure beyond its noise
constexpr double kMostRunning = 2.0;       // px: a larger error is the eyes' own, and is learned
constexpr double kMostSurprise = 3.0;
}  // namespace

double spread_ratio(const std::vector<Observation>& observations) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (const Observation& o : observations) {
    if (!o.inlier) continue;
    const double x = o.uvd_cur.x();
    const double y = o.uvd_cur.y();
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
  }
  if (n < 3) return 0.0;
  sxx = sxx / n - sx / n * (sx / n);
  sxy = sxy / n - sx / n * (sy / n);
  syy = syy / n - sy / n * (sy / n);
  const double half_trace = 0.5 * (sxx + syy);
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - (sxx * syy - sxy * sxy)));
  const double larger = half_trace + root;
  return larger > 0.0 ? std::max(0.0, half_trace - root) / larger : 0.0;
}

double excess_change(const std::vector<Observation>& observations, std::vector<float>& scratch) {
  const auto median = [&](float Observation::*member) {
    scratch.clear();
    for (const Observation& o : observations) {
      if (o.inlier && o.reference == 0) scratch.push_back(o.*member);
    }
    if (scratch.empty()) return 0.0;
    const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
    std::nth_element(scratch.begin(), middle, scratch.end());
    return static_cast<double>(*middle);
  };
  const double change = median(&Observation::change);
  const double difference = median(&Observation::difference);
  return (change - difference) / std::max(kLeastDifference, std::min(change, difference));
}

double change_of_light(const std::vector<Observation>& observations, std::vector<float>& scratch) {
  scratch.clear();
  for (const Observation& o : observations) {
    if (o.inlier && o.reference == 0) scratch.push_back(o.brighter);
  }
  if (scratch.empty()) return 0.0;
  const auto smallest_but = [&scratch](std::size_t tenths) {
    const auto at = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() * tenths / 10);
    std::nth_element(scratch.begin(), at, scratch.end());
    return *at;
  };
  const float common = smallest_but(5);
  for (float& brighter : scratch) brighter = std::abs(brighter - common);
  return static_cast<double>(smallest_but(9));
}

double surprise(const Motion& motion) {
  if (!(motion.offset_information > 0.0) || std::abs(motion.offset_px) > kMostRunning) return 1.0;
  const double variance = kOffsetNoise * kOffsetNoise + 1.0 / motion.offset_information;
  return std::min(kMostSurprise, 1.0 + motion.offset_px * motion.offset_px / variance);
}

double disparity_error_px(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                          const RigidTransform& T_prev_cur, const StereoModel& model) {
  const RigidTransform T_cur_prev = T_prev_cur.inverse();
  double n = 0.0, sum = 0.0;
  for (const Observation& o : observations) {
    if (!o.inlier) continue;
    const Eigen::Vector3d in_ref = model.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    const Eigen::Vector3d p = T_cur_prev * (T_prev_ref[static_cast<std::size_t>(o.reference)] * in_ref);
    const double error = o.uvd_cur.z() + model.doffs_px - model.fx_px * model.baseline_m / p.z();
    n += 1.0;
    sum += error * error;
  }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

Status validate(const Motion& motion, double eigenvalue_ratio, double disparity_error_px, const VoParams& params) {
  if (motion.inliers < params.min_inliers) return Status::too_few_features;
  if (eigenvalue_ratio < params.min_eigenvalue_ratio || !motion.converged) return Status::degenerate;
  const double error_px = std::max(motion.error_px, disparity_error_px);
  if (error_px > params.max_reprojection_error_px) return Status::reprojection_error;
  return Status::valid;
}

}  // namespace cliquevo::vo
