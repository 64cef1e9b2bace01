// SPDX-License-Identifier: BSD-3-Clause
// Recorded sequences as frame sources: KITTI odometry, KITTI raw, KITTI-360, EuRoC, two folders of images, images of
// both eyes in one folder or side by side, told apart by what is in the folder; or LCM event logs with stereo pairs, a
// file or a folder of such.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/calibration_file.h"
#include "drivers/frame_source.h"
#include "drivers/images/bayer.h"

namespace cliquevo::drivers {

struct RecordingOptions {
  std::string path;
  std::string calibration;  // file; empty = the recording's own
  CalibrationOptions calibration_options;
  std::optional<double> rate_hz;           // gives the stamps, whatever times are there
  std::int64_t first = 0;                  // first pair to play
  std::int64_t last = -1;                  // last pair to play, -1 = the last there is
  std::int64_t every = 1;                  // play every k-th pair
  std::optional<double> pair_tolerance_s;  // between the stamps of the two eyes; default a quarter period
  std::string left_mask;                   // image files, 0 = the vehicle's own parts; empty: mask_left.png in the
  std::string right_mask;                  // recording when there is one
  Bayer bayer = Bayer::automatic;          // whether the images are raw Bayer mosaics
  bool side_by_side = false;               // each image holds both eyes, left half and right half; also seen by itself
  std::string channel;                     // of a log; empty = VO_STEREO, else the only one with stereo pairs
  bool pingpong = false;   // never ends: forward, then backward, ...; the stamps go on by the same steps
  bool read_ahead = true;  // a thread decodes the next pairs meanwhile; same pairs, same errors, same order
};

// The size of the images is that of the first pair played. One of another size later, one that is torn, and a stamp
// that steps back or repeats are errors of next(): such a pair is to be skipped. A pair's index is its position in the
// whole recording (so `first`, `first + every`, ...), and goes on rising in ping-pong. On an error of next() the pair's
// index and stamp_ns are those of the bad pair, its images are not to be used, and the following next() goes on behind
// it.
Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options);

}  // namespace cliquevo::drivers
