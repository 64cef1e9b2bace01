// SPDX-License-Identifier: BSD-3-Clause
// What becomes of each estimate: messages, pictures, trajectory, counts. Runs on the output thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "daemon/diagnostics.h"
#include "daemon/lcm/feature_tap.h"
#include "daemon/lcm/image_tap.h"
#include "daemon/lcm/publisher.h"
#include "daemon/pipeline/config.h"
#include "daemon/points_thread.h"
#include "daemon/trajectory_sink.h"

namespace cliquevo::daemon {

struct Output {
  // mask: of the odometry's features, for pictures. trajectory: the file to write; empty = none.
  static Result<std::unique_ptr<Output>> make(Publisher publisher, const Config& config, const StereoModel& model,
                                              ImageView<const std::uint8_t> mask, const std::string& trajectory);
  void take(const PublishedFrame& frame);

  Publisher publisher;
  ImageTap tap;
  FeatureTap feature_tap;
  std::unique_ptr<PointsThread> points;  // none: not configured
  StereoModel model;
  std::optional<TrajectorySink> trajectory;
  SentCounts sent;
  LatestDiagnostics diagnostics;
};

}  // namespace cliquevo::daemon
