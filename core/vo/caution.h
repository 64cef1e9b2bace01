// SPDX-License-Identifier: BSD-3-Clause
// Stricter limits after a suspicious frame: until the next valid one (moving ground texture), or for three frames
// (moving objects).
#pragma once

#include <algorithm>

#include "core/vo/evidence.h"

namespace cliquevo::vo {

class Caution {
 public:
  // By which the bounds on contradiction and running ground are scaled.
  double bound_scale() const { return any() ? kStricter : 1.0; }
  bool any() const { return running_ground_ || frames_ > 0; }

  // After a comparison of two frames: its failed checks make the next frames suspicious.
  void learn(const Checks& checks) {
    if (checks[Check::running_ground].fails()) running_ground_ = true;
    const Evidence& contradiction = checks[Check::contradiction];
    // By the full bound: where people move there is always some contradiction.
    if (contradiction.applies && contradiction.value * bound_scale() > contradiction.bound) frames_ = kFrames + 1;
  }
  // After a frame. Running ground stays suspicious until a frame is valid; things that move, for some frames.
  void next(bool valid) {
    frames_ = valid ? 0 : std::max(0, frames_ - 1);
    if (valid) running_ground_ = false;
  }

 private:
  static constexpr int kFrames = 3;
  static constexpr double kStricter = 0.5;
  bool running_ground_ = false;
  int frames_ = 0;  // to come
};

}  // namespace cliquevo::vo
