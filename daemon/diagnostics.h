// SPDX-License-Identifier: BSD-3-Clause
// What the output thread finds and the main one reports.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>

#include "core/vo/visual_odometry.h"

namespace cliquevo::daemon {

// Counted by the output thread, read by the main one.
struct SentCounts {
  std::atomic<std::int64_t> valid{0};
  std::atomic<std::int64_t> send_errors{0};
};

// The last estimate's state of the cameras; written by the output thread, read by the main one.
class LatestDiagnostics {
 public:
  void take(const vo::Estimate& estimate) {
    const std::lock_guard guard(mutex_);
    calibration_ = estimate.calibration;
    vehicle_part_ = estimate.vehicle_part;
  }
  std::pair<vo::CalibrationCheck, vo::VehiclePart> read() const {
    const std::lock_guard guard(mutex_);
    return {calibration_, vehicle_part_};
  }

 private:
  mutable std::mutex mutex_;
  vo::CalibrationCheck calibration_;
  vo::VehiclePart vehicle_part_;
};

}  // namespace cliquevo::daemon
