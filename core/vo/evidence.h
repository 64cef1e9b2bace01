// SPDX-License-Identifier: BSD-3-Clause
// The checks on a frame's motion as data: what was found, what was allowed.
#pragma once

#include <array>
#include <cstdint>

#include "core/vo/check_list.h"

namespace cliquevo::vo {

// "running ground"
const char* check_name(Check check);

// A check's value beside what is allowed.
struct Evidence {
  double value = 0.0;    // what was found
  double bound = 0.0;    // what is allowed
  bool applies = false;  // whether there was anything to check
  // Whether it applies and the value is above the bound.
  bool fails() const { return applies && !(value <= bound); }
  // value / bound: above 1 fails; 0 where the check does not apply.
  double ratio() const { return applies ? (bound > 0.0 ? value / bound : (value > 0.0 ? 1e9 : 0.0)) : 0.0; }
};

// The evidence of every check.
class Checks {
 public:
  // Of one check.
  Evidence& operator[](Check check) { return evidence_[static_cast<std::size_t>(check)]; }
  // Of one check.
  const Evidence& operator[](Check check) const { return evidence_[static_cast<std::size_t>(check)]; }
  // Bit k: check k failed.
  std::uint32_t failed() const {
    std::uint32_t mask = 0;
    for (std::size_t k = 0; k < kChecks; ++k) mask |= evidence_[k].fails() ? 1U << k : 0U;
    return mask;
  }

 private:
  std::array<Evidence, kChecks> evidence_{};
};

}  // namespace cliquevo::vo
