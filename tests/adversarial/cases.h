// SPDX-License-Identifier: BSD-3-Clause
// Generated cases in which a visual odometry may fail unreported: short windows out of rendered courses with exact
// truth, disturbed in every way we know of, each labelled by its disturbance.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "drivers/frame_source.h"

namespace cliquevo::test {

enum class Kind {
  plain,
  blank,        // both cameras grey
  noise,        // both cameras nothing but noise
  frozen,       // the right camera keeps its last image
  swapped,      // left and right exchanged
  gap,          // two frames 2 s apart
  calibration,  // the right camera turned by a degree that the calibration does not know
  covered,      // 70 % of the left camera
  mover,        // something that moves otherwise fills most of the view
  rotation,     // on the spot
  flare,        // a glow that stays with the lens, and a veil
  night,        // hardly any light
  water,        // the ground's texture drifts
  blur,         // out of focus
  count
};
const char* kind_name(Kind kind);

struct Case {
  Kind kind = Kind::plain;
  std::string text;          // what it is, to find it again
  drivers::SourceInfo info;  // with the calibration that the odometry gets
  std::vector<drivers::StereoPair> pairs;
  // Frames whose motion since the one before can be had from the images; empty verdict expected nowhere else.
  std::vector<bool> solvable;
  std::size_t judged_from = 1;
};

class CaseMaker {
 public:
  CaseMaker();  // renders, or reads what was rendered before
  static Kind kind_of(std::uint64_t k) { return static_cast<Kind>(k % static_cast<std::uint64_t>(Kind::count)); }
  // Cases from here on are a second family: about half of them are seen by a rough camera. Case kRough + k is not case
  // k.
  static constexpr std::uint64_t kRough = 1'000'000;
  // Case k is the same wherever and whenever it is made; kinds take turns.
  Case make(std::uint64_t k);

 private:
  struct Course {
    drivers::SourceInfo info;
    std::vector<drivers::StereoPair> pairs;
  };
  const Course& course(const std::string& options);
  std::map<std::string, Course> courses_;
};

}  // namespace cliquevo::test
