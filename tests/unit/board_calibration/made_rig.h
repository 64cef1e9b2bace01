// SPDX-License-Identifier: BSD-3-Clause
// Random rigs and what they see of a board, with exact truth.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/board_calibration/rig.h"

namespace cliquevo::calibration {

// How many rigs a test may take: instructions are ten times as slow under the address sanitizer.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr std::uint64_t kRigs = 4;
#else
inline constexpr std::uint64_t kRigs = 20;
#endif

struct MadeRig {
  Rig rig;
  Board board;
  std::vector<RigidTransform> T_left_board;
  std::vector<View> views;  // corners with noise
  std::vector<View> exact;  // the same without
};

// Pinholes of 40 to 110 degrees of view and, each fourth, a fisheye of 120 to 190; baselines of 5 to 60 cm; a board as
// large as suits the rig. noise_px: standard deviation of a coordinate.
MadeRig make_rig(std::uint64_t seed, int views, double noise_px);

}  // namespace cliquevo::calibration
