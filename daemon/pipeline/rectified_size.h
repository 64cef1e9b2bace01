// SPDX-License-Identifier: BSD-3-Clause
// `rectify.scale: auto`: the largest size of the rectified pair at which this machine keeps the frame rate.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

struct RectifiedSize {
  double scale = 1.0;
  bool measured = false;        // false: it was given, or no rate has to be kept
  bool fits = true;             // whether the rate is kept
  double cost_ms = 0.0;         // of a frame at this scale
  double native_cost_ms = 0.0;  // and at the native one; measured, or reckoned from a smaller one
  double budget_ms = 0.0;
};

// The choice alone. cost_ms: measures a frame at a scale. It is called for few scales, small ones first, and for the
// native one only where that may fit.
Result<RectifiedSize> pick_scale(std::int64_t native_pixels, double budget_ms,
                                 const std::function<Result<double>(double scale)>& cost_ms);

// Runs stereo and odometry on made-up images for about a second, on threads like those that will do the work. Nothing
// is measured where the configuration gives a scale, or where frames wait for the pipeline (a recording as fast as
// possible): native then, so that it does not depend on the machine.
Result<RectifiedSize> choose_rectified_size(const Config& config, const drivers::SourceInfo& source);

// "native size 512x384 (rectify.scale auto): stereo and odometry take 6.1 ms of each frame's 33.3 ms". Empty: nothing
// was measured.
std::string describe(const RectifiedSize& size, const drivers::SourceInfo& source);

}  // namespace cliquevo::daemon
