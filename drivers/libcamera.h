// SPDX-License-Identifier: BSD-3-Clause
// Stereo pairs through libcamera: two cameras, or one that delivers both images.
#pragma once

#include <memory>
#include <vector>

#include "drivers/live/camera_options.h"

namespace cliquevo::drivers {

// One try; trouble gives the reason of a failure. From then on a camera that is unplugged is looked for under its id
// until it is back.
Result<std::unique_ptr<FrameSource>> open_libcamera(const CameraOptions& options, OpenTrouble& trouble);

std::vector<SeenCamera> list_libcamera();

}  // namespace cliquevo::drivers
