// SPDX-License-Identifier: BSD-3-Clause
// What became of a frame's features, for displays: VO_FEATURES. The odometry thread gives, the output
// thread takes; neither waits for the other.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/stages.h"

namespace cliquevo::daemon {

struct TappedFeatures {
  TimestampNs stamp_ns = 0;
  vo::Checks checks;
  std::vector<vo::SeenFeature> features;
};

class FeatureTap {
 public:
  // most: features that a frame may have; takes its memory here. Nothing happens where it is not on.
  FeatureTap(bool on, std::size_t most);

  // Odometry thread: copies when the last frame's have been taken. No allocation once warm, no lock.
  void offer(const OdometryStage& odometry);

  // Output thread: what was copied since, or nullptr; good until give_back().
  const TappedFeatures* take() const { return full_.load(std::memory_order_acquire) ? tapped_.get() : nullptr; }
  void give_back() { full_.store(false, std::memory_order_release); }

 private:
  bool on_;
  std::unique_ptr<TappedFeatures> tapped_;
  std::atomic<bool> full_{false};
};

}  // namespace cliquevo::daemon
