// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/seen_features.h"

#include <algorithm>

namespace cliquevo::vo {

namespace {

float f(double value) { return static_cast<float>(value); }

void add_observations(const Seen& seen, std::vector<SeenFeature>& out) {
  for (const Observation& o : *seen.observations) {
    const FeatureRole inlier = o.reference == 0 ? FeatureRole::inlier : FeatureRole::of_key;
    out.push_back({f(o.uvd_cur.x()), f(o.uvd_cur.y()), f(o.uvd_ref.x()), f(o.uvd_ref.y()), f(o.uvd_cur.z()),
                   f(o.error_px), o.inlier ? inlier : FeatureRole::outlier});
  }
}

// Features of the reference without an observation, where the motion puts them in the new image.
void add_missing(const Seen& seen, std::vector<SeenFeature>& out) {
  const RigidTransform T_cur_ref = seen.T_ref_cur.inverse();
  const auto& observations = *seen.observations;
  for (std::size_t i = 0; i < seen.reference->features.size(); ++i) {
    const bool found = std::any_of(observations.begin(), observations.end(), [i](const Observation& o) {
      return o.reference == 0 && o.feature == static_cast<int>(i);
    });
    const Feature& feature = seen.reference->features[i];
    const Eigen::Vector3d point = T_cur_ref * feature.point;
    if (found || !(point.z() > 0.01)) continue;
    const Eigen::Vector3d uvd = seen.model.project(point);
    if (!(uvd.x() >= 0.0 && uvd.x() < seen.model.width && uvd.y() >= 0.0 && uvd.y() < seen.model.height)) continue;
    out.push_back({f(uvd.x()), f(uvd.y()), f(feature.x), f(feature.y), f(uvd.z()), 0.0F, FeatureRole::not_found});
  }
}

void add_movers(const Seen& seen, std::vector<SeenFeature>& out) {
  for (int k = 0; k < seen.movers.count; ++k) {
    const Mover& mover = seen.movers.mover[static_cast<std::size_t>(k)];
    for (int i = 0; i < mover.points; ++i) {
      const MoverPoint& p = mover.point[static_cast<std::size_t>(i)];
      const Eigen::Vector3d now = p.point.cast<double>();
      const Eigen::Vector3d before = mover.T_prev_cur * now;
      if (!(before.z() > 0.01 && now.z() > 0.01)) continue;
      const Eigen::Vector3d from = seen.model.project(before);
      out.push_back(
          {p.x_px, p.y_px, f(from.x()), f(from.y()), f(seen.model.project(now).z()), 0.0F, FeatureRole::mover});
    }
  }
}

}  // namespace

void list_seen(const Seen& seen, std::vector<SeenFeature>& out) {
  out.clear();
  if (seen.observations != nullptr && seen.reference != nullptr && !seen.observations->empty()) {
    add_observations(seen, out);
    add_missing(seen, out);
  } else if (seen.current != nullptr) {
    for (const Feature& feature : seen.current->features) {
      out.push_back(
          {f(feature.x), f(feature.y), f(feature.x), f(feature.y), f(feature.disparity_px), 0.0F, FeatureRole::corner});
    }
  }
  add_movers(seen, out);
}

}  // namespace cliquevo::vo
