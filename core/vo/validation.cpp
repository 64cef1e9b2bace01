// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/validation.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

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
  return median(&Observation::change) - median(&Observation::difference);
}

Status validate(const Motion& motion, double eigenvalue_ratio, const VoParams& params) {
  if (motion.inliers < params.min_inliers) return Status::too_few_features;
  if (eigenvalue_ratio < params.min_eigenvalue_ratio || !motion.converged) return Status::degenerate;
  if (motion.error_px > params.max_reprojection_error_px) return Status::reprojection_error;
  return Status::valid;
}

}  // namespace cliquevo::vo
