// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/image.h"
#include "core/vo/vo_params.h"
#include "stereo/rectify_params.h"
#include "stereo/stereo_params.h"

namespace cliquevo {

// Everything that steers the way from images to poses. The defaults are the shipped ones.
struct OdometryParams {
  stereo::StereoParams stereo;    // disparity
  vo::VoParams odometry;          // motion
  stereo::RectifyParams rectify;  // size and field of view
};

// What must not be used of each camera's images, e.g. parts of the vehicle: images of the input's size, 0 = not to be
// used. An empty view: all of the image may be used.
struct OdometryMasks {
  ImageView<const std::uint8_t> left;   // size of the left images
  ImageView<const std::uint8_t> right;  // size of the right images
};

}  // namespace cliquevo
