// SPDX-License-Identifier: BSD-3-Clause
// How the board is moved before the cameras: it is held in a place for a while, then taken to the next.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "drivers/simulator.h"
#include "drivers/simulator/board_pattern.h"
#include "drivers/simulator/board_rig.h"

namespace cliquevo::drivers::sim {

// Of one thread at a time.
class BoardCourse {
 public:
  // Fails when the board is too large, or too small, to be held before both cameras.
  static Result<BoardCourse> make(const SimulatorOptions& options, const BoardPattern& pattern,
                                  const StereoCalibration& rig);
  // Board to the left camera, `time_s` after the middle of frame 0's exposure.
  RigidTransform T_left_board(double time_s) const;

 private:
  BoardCourse(const SimulatorOptions& options, const BoardPattern& pattern, const StereoCalibration& rig);
  std::optional<RigidTransform> choose(std::int64_t k) const;
  RigidTransform held(const Eigen::Vector3d& direction, double far_m, double tilt, double tilt_to, double roll) const;
  bool shown(const SimulatedLens& lens, const RigidTransform& T) const;
  bool is_seen(const RigidTransform& T, std::int64_t k) const;
  // The place at which it is held as the k-th.
  const RigidTransform& place(std::int64_t k) const;

  BoardPattern pattern_;
  SimulatedLens left_, right_;
  RigidTransform T_right_left_;
  std::uint64_t seed_ = 0;
  double view_rad_ = 1.0;
  bool whole_ = true;  // it is found only where all of it is seen
  double hold_s_ = 0.0, move_s_ = 0.0, period_s_ = 0.0;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();       // of the board, about which it turns
  mutable std::map<std::int64_t, RigidTransform> places_;  // those of late
};

}  // namespace cliquevo::drivers::sim
