// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/libcamera.h"
#include "drivers/libcamera/libcamera_pairs.h"
#include "drivers/live/pairs_source.h"

namespace cliquevo::drivers {

Result<std::unique_ptr<FrameSource>> open_libcamera(const CameraOptions& options, OpenTrouble& trouble) {
  return open_pairs_source<LibcameraPairs>(options, "libcamera", trouble);
}

}  // namespace cliquevo::drivers
