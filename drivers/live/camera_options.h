// SPDX-License-Identifier: BSD-3-Clause
// Settings of a live stereo pair, whichever family of drivers it is of.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/calibration/calibration_options.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

enum class CameraTrigger {
  off,       // the cameras run freely at rate_hz
  software,  // this program triggers both, one right after the other
  hardware,  // a signal on trigger_line
  action,    // one packet for both (GigE Vision action command)
};
enum class CameraLayout {
  two_cameras,
  side_by_side,  // one camera, both images in one: left half, right half
  interleaved,   // one camera, pixel by pixel in turn: left, right
};

// What stands in the way of opening a camera.
enum class OpenTrouble {
  lasting,  // nothing that waiting cures: a wrong setting, a calibration that cannot be read
  held,     // another program has it, or had it until a moment ago
  absent,   // it is not there, not yet or no more
};

struct CameraOptions {
  std::string left;         // serial number, address, stable name or path; one camera for both images: this one alone
  std::string right;        //
  std::string calibration;  // file or folder
  CalibrationOptions calibration_options;
  double rate_hz = 30.0;
  int width = 0;  // of one image [px]; 0 = as the camera is set
  int height = 0;
  int offset_x = 0;  // where the region of interest begins [px]
  int offset_y = 0;
  int binning = 1;
  std::string pixel_format;           // empty = grey with 8 bits where offered
  std::optional<double> exposure_us;  // none: the left camera's own control, followed by the right
  std::optional<double> gain;         // likewise, in the camera's unit
  double exposure_max_us = 0.0;       // limit of the automatic exposure time; 0 = none
  CameraTrigger trigger = CameraTrigger::off;
  std::string trigger_line = "Line1";
  bool shared_clock = false;  // both cameras stamp by one clock
  bool ptp = false;           // switch it on, where the cameras offer it
  int packet_size = 0;        // bytes; 0 = as large as gets through
  bool packet_resend = true;
  CameraLayout layout = CameraLayout::two_cameras;
  std::string controls;   // further ones by name: "name=value,name=value"
  std::string left_mask;  // image files, 0 = the vehicle's own parts
  std::string right_mask;
  bool needs_calibration = true;  // not a key: without, images alone are wanted
  double patience_s = 12.0;  // not a key: how long a camera held by another program is retried before that is an error

  Result<void> check() const;        // ranges
  Result<void> check_names() const;  // what must be given for cameras to be opened
};

// Whether the calibration can be read at all: known before any camera is there.
Result<void> check_live_calibration(const CameraOptions& options);
// Reads calibration and masks for images of this size.
Result<SourceInfo> live_source_info(const CameraOptions& options, int width, int height,
                                    const std::string& description);

// A camera that can be seen.
struct SeenCamera {
  std::string family;  // as in source.type: v4l2
  std::string id;      // what source.cameras.left takes
  std::string description;
  std::vector<std::string> formats;  // where they are known without opening it
};

}  // namespace cliquevo::drivers
