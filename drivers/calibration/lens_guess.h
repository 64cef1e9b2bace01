// SPDX-License-Identifier: BSD-3-Clause
// Four distortion terms without a name are OpenCV's k1 k2 p1 p2, or k1 k2 k3 k4 of its fisheye module. Decided by the
// numbers; where they do not suffice, by the images (examine.h) or the user.
#pragma once

#include <string>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

struct LensGuess {
  std::string lens;  // plumb_bob, equidistant; empty = the numbers fit both
  std::string note;  // for the user, where it is not the plain reading
};

LensGuess guess_lens(const CameraCalibration& left, const std::vector<double>& D_left, const CameraCalibration& right,
                     const std::vector<double>& D_right);

// The question that is left.
Error lens_question(const std::string& where);

}  // namespace cliquevo::drivers
