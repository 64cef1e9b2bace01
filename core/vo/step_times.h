// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cliquevo::vo {

// Time spent in each step of the last frame.
struct StepTimes {
  std::int64_t features_ns = 0;
  std::int64_t scores_ns = 0;
  std::int64_t matches_ns = 0;
  std::int64_t clique_ns = 0;
  std::int64_t motion_ns = 0;
  std::int64_t total_ns = 0;
};

}  // namespace cliquevo::vo
