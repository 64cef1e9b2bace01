// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/result.h"

namespace cliquevo::vo {

// Everything that steers the odometry. Defaults are the shipped ones: one set for every vehicle.
struct VoParams {
  int max_features = 500;  // features kept a frame

  Result<void> check() const;
};

}  // namespace cliquevo::vo
