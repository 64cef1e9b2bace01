// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cliquevo::vo {

// Time spent in each step of the last frame.
struct StepTimes {
  std::int64_t features_ns = 0;  // corners and descriptors
  std::int64_t scores_ns = 0;    // score matrix
  std::int64_t matches_ns = 0;   // co-occurring minima
  std::int64_t clique_ns = 0;    // consistent matches
  std::int64_t motion_ns = 0;    // motion and checks
  std::int64_t total_ns = 0;     // all of it
};

}  // namespace cliquevo::vo
