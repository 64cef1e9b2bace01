// SPDX-License-Identifier: BSD-3-Clause
// Recorded sequences as frame sources: KITTI odometry, KITTI raw, EuRoC, or two folders of images; told apart by what
// is in the folder.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/frame_source.h"

namespace cliquevo::drivers {

struct RecordingOptions {
  std::string path;
  std::string calibration;                 // file; empty = the recording's own
  std::optional<double> rate_hz;           // gives stamps to images that have none
  std::int64_t first = 0;                  // first pair to play
  std::int64_t last = -1;                  // last pair to play, -1 = the last there is
  std::int64_t every = 1;                  // play every k-th pair
  std::optional<double> pair_tolerance_s;  // between the stamps of the two eyes; default a quarter period
  std::string left_mask;                   // image files, 0 = the vehicle's own parts; empty: mask_left.png in the
  std::string right_mask;                  // recording when there is one
};

Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options);

}  // namespace cliquevo::drivers
