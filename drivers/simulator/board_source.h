// SPDX-License-Identifier: BSD-3-Clause
// A calibration board that is moved before the cameras, with exact truth: the rig, and where the board is.
#pragma once

#include <memory>

#include "core/base/rigid_transform.h"
#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

class BoardSimulator : public Simulator {
 public:
  // Of the last pair: board to the raw left camera in the middle of the left exposure, and to the raw right camera in
  // the middle of its own, which is skew_ms later.
  virtual RigidTransform truth_T_left_board() const = 0;
  virtual RigidTransform truth_T_right_board() const = 0;
};

// options: checked, with values of their camera set.
Result<std::unique_ptr<Simulator>> open_board(const SimulatorOptions& options);

}  // namespace cliquevo::drivers::sim
