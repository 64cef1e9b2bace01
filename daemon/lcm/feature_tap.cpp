// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/feature_tap.h"

namespace cliquevo::daemon {

FeatureTap::FeatureTap(bool on, std::size_t most) : on_(on), tapped_(std::make_unique<TappedFeatures>()) {
  // Of two references each, those not found, and the movers' points.
  if (on) tapped_->features.reserve(3 * most + vo::kMostMovers * vo::kMostMoverPoints);
}

void FeatureTap::offer(const OdometryStage& odometry) {
  if (!on_ || full_.load(std::memory_order_acquire)) return;
  const vo::Estimate& estimate = odometry.estimate();
  tapped_->stamp_ns = estimate.stamp_ns;
  tapped_->checks = estimate.checks;
  odometry.list_features(tapped_->features);
  full_.store(true, std::memory_order_release);
}

}  // namespace cliquevo::daemon
