// SPDX-License-Identifier: BSD-3-Clause
// Stereo pairs of GigE Vision or USB3 Vision cameras, through Aravis.
#pragma once

#include <memory>
#include <vector>

#include "drivers/live/camera_options.h"

namespace cliquevo::drivers {

// One try, in which a camera that another program still holds is retried for options.patience_s; trouble gives the
// reason it failed. From then on a lost camera is looked for until it is back.
Result<std::unique_ptr<FrameSource>> open_aravis(const CameraOptions& options, OpenTrouble& trouble);

// What answers on the network and USB; takes a second.
std::vector<SeenCamera> list_aravis();

}  // namespace cliquevo::drivers
