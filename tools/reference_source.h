// SPDX-License-Identifier: BSD-3-Clause
// A recording together with its reference: each pair comes with the pose that the reference has for it.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "daemon/pipeline/trajectory_file.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools {

// reference: of the rectified left camera (read_reference()). By the pairs' positions in the recording, their numbers,
// or their stamps, within 10 ms. Pairs that it has no pose for come without.
std::unique_ptr<drivers::FrameSource> with_reference(std::unique_ptr<drivers::FrameSource> source,
                                                     daemon::Trajectory reference);

}  // namespace cliquevo::tools
