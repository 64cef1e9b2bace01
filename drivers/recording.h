// SPDX-License-Identifier: BSD-3-Clause
// Recorded sequences as frame sources: KITTI odometry, KITTI raw, KITTI-360, EuRoC, two folders of images, images of
// both cameras in one folder or side by side, recognised by what the folder holds; or LCM event logs with stereo pairs,
// a file or a folder of such.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "drivers/frame_source.h"
#include "drivers/recording/recording_options.h"

namespace cliquevo::drivers {

// The size of the images is that of the first pair played. One of another size later, one that is torn, and a stamp
// that steps back or repeats are errors of next(): such a pair is to be skipped. A pair's index is its position in the
// whole recording (so `first`, `first + every`, ...), and goes on rising in ping-pong. On an error of next() the pair's
// index and stamp_ns are those of the bad pair, its images are not to be used, and the following next() goes on behind
// it.
Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options);

}  // namespace cliquevo::drivers
