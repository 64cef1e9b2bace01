// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/pairs_source.h"
#include "drivers/v4l2.h"
#include "drivers/v4l2/v4l2_pairs.h"

namespace cliquevo::drivers {

Result<std::unique_ptr<FrameSource>> open_v4l2(const CameraOptions& options, OpenTrouble& trouble) {
  return open_pairs_source<V4l2Pairs>(options, "V4L2", trouble);
}

}  // namespace cliquevo::drivers
