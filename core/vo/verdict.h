// SPDX-License-Identifier: BSD-3-Clause
// From the checks to the verdict: the only place where a status is decided.
#pragma once

#include "core/vo/evidence.h"

namespace cliquevo::vo {

// The verdict on a frame; the numbers go out over LCM.
enum class Status : std::int8_t {
  no_data = 0,             // first frame: nothing to compare with
  valid = 1,               //
  too_few_features = 2,    // features, matches or clique too small
  degenerate = 3,          // spread of the inliers too one-sided to fix the motion
  reprojection_error = 4,  // the inliers do not agree on one motion
  ambiguous = 5,           // a second motion is well supported, or much of the picture contradicts the one found
  weak = 6,                // a motion was found, but by its own covariance it is hardly known
};
// "too few features"
const char* status_name(Status status);

// That of the first check that fails, in the order of the table; valid where none does.
Status verdict(const Checks& checks);

}  // namespace cliquevo::vo
