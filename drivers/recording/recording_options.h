// SPDX-License-Identifier: BSD-3-Clause
// How a recording is to be read.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/calibration/calibration_options.h"
#include "drivers/images/bayer.h"

namespace cliquevo::drivers {

struct RecordingOptions {
  std::string path;
  std::string calibration;  // file; empty = the recording's own
  CalibrationOptions calibration_options;
  bool needs_calibration = true;           // false: images alone will do; calibration files are not looked at
  std::optional<double> rate_hz;           // gives the stamps, whatever times are there
  std::int64_t first = 0;                  // first pair to play
  std::int64_t last = -1;                  // last pair to play, -1 = the last there is
  std::int64_t every = 1;                  // play every k-th pair
  std::optional<double> pair_tolerance_s;  // between the stamps of the two cameras; default a quarter period
  std::string left_mask;                   // image files, 0 = the vehicle's own parts; empty: mask_left.png in the
  std::string right_mask;                  // recording when there is one
  Bayer bayer = Bayer::automatic;          // whether the images are raw Bayer mosaics
  bool side_by_side = false;               // left and right half of each image; also seen by itself
  std::string channel;                     // of a log; empty = VO_STEREO, else the only one with stereo pairs
  std::string topics;                      // of a bag: LEFT,RIGHT[,LEFT_INFO,RIGHT_INFO]; empty = by types and names
  // The user states which camera is which: nothing is concluded from a calibration whose first camera is the right one.
  bool order_stated = false;
  bool pingpong = false;   // never ends: forward, then backward, ...; the stamps go on by the same steps
  bool read_ahead = true;  // a thread decodes the next pairs meanwhile; same pairs, same errors, same order
};

}  // namespace cliquevo::drivers
