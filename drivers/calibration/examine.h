// SPDX-License-Identifier: BSD-3-Clause
// A calibration for these very images: what the file leaves open, the first pairs decide; what they contradict is
// reported.
#pragma once

#include <string>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "drivers/calibration/calibration.h"

namespace cliquevo::drivers {

struct ImagePairView {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
};

// Reads the calibration and looks at the pairs (a few; none leave it at the file):
//  - four distortion terms of an unnamed lens: the model whose rows agree better; an Error where neither does;
//  - images that are rectified already where the calibration is of raw ones: an Error that names --rectified;
//  - a baseline that puts everything far away: a note.
// Notes stand in the calibration.
Result<StereoCalibration> read_calibration_for(const CalibrationRequest& request,
                                               const std::vector<ImagePairView>& pairs);

// One line on what the pairs contradict in a calibration that was read already; empty = nothing.
std::string contradiction(const StereoCalibration& calibration, const std::vector<ImagePairView>& pairs);

}  // namespace cliquevo::drivers
