// SPDX-License-Identifier: BSD-3-Clause
// Stereo pairs through Video4Linux: two cameras, or one that delivers both images.
#pragma once

#include <memory>
#include <vector>

#include "drivers/live/camera_options.h"

namespace cliquevo::drivers {

// One try; trouble gives the reason of a failure. From then on a camera that is unplugged is looked for under its name
// until it is back.
Result<std::unique_ptr<FrameSource>> open_v4l2(const CameraOptions& options, OpenTrouble& trouble);

// Every camera that captures video, with its stable name where it has one.
std::vector<SeenCamera> list_v4l2();

}  // namespace cliquevo::drivers
