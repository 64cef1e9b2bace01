// SPDX-License-Identifier: BSD-3-Clause
// Stereo pairs of GigE Vision or USB3 Vision cameras, through Aravis.
#pragma once

#include <memory>
#include <vector>

#include "drivers/camera_options.h"

namespace cliquevo::drivers {

// Waits for both cameras to deliver their first frames' geometry; a camera that another program still holds is asked
// again for some seconds. From then on a lost camera is looked for until it is back.
Result<std::unique_ptr<FrameSource>> open_aravis(const CameraOptions& options);

// What answers on the network and USB; takes a second.
std::vector<SeenCamera> list_aravis();

}  // namespace cliquevo::drivers
