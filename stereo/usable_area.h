// SPDX-License-Identifier: BSD-3-Clause
// Which part of a rectified image may be used: not the vehicle's own parts, not beyond the raw image's edge.
#pragma once

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "stereo/rectify.h"

namespace cliquevo::stereo {

// mask: of the raw image, 0 = not to be used; empty = all of it may be. The area has the rectified size, 0 = not to be
// used; it is empty where all of it may be.
Result<Image<std::uint8_t>> usable_area(const Rectifier& rectifier, CameraSide side, ImageView<const std::uint8_t> mask,
                                        const CameraCalibration& raw);

// Drops disparities whose right pixel must not be used: no feature, then, rests on it.
void drop_unusable(ImageView<const std::uint8_t> right_area, ImageView<std::int16_t> disparity);

}  // namespace cliquevo::stereo
