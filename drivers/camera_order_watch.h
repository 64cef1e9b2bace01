// SPDX-License-Identifier: BSD-3-Clause
// Looks at the first pairs of any source, and now and then at later ones, whether left is left and right is right; and
// exchanges the cameras of a source that is known to have them the wrong way round.
#pragma once

#include <memory>

#include "drivers/frame_source.h"

namespace cliquevo::drivers {

// swap: the images (and masks) of both cameras change places, the calibration stays. finding() and status() of
// the source that is returned report what is wrong with its cameras.
std::unique_ptr<FrameSource> watch_camera_order(std::unique_ptr<FrameSource> source, bool swap);

}  // namespace cliquevo::drivers
