// SPDX-License-Identifier: BSD-3-Clause
// Reading a calibration: the request, and how the file of the other camera is found.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/result.h"
#include "drivers/calibration/calibration_options.h"

namespace cliquevo::drivers {

struct NamedText {
  std::string path;
  std::string text;
};

struct CalibrationRequest {
  std::string path;  // file or folder
  int width = 0;     // of the images, 0 = unknown
  int height = 0;
  int left_camera = 0;  // their numbers, where a file holds more than two cameras (KITTI's 0..3)
  int right_camera = 1;
  CalibrationOptions options;
  std::vector<NamedText> texts;    // where it is in memory: the text of `path`, then of the other camera
  std::vector<std::string> notes;  // what is to be said of it besides
};

Result<StereoCalibration> read_calibration(const CalibrationRequest& request);

// A calibration may lie in more files than one. Returns the first of these paths that exists.
using OtherFile = std::function<Result<NamedText>(const std::vector<std::string>& paths)>;

// Any format, from memory.
Result<StereoCalibration> parse_calibration(const std::string& text, const CalibrationRequest& request,
                                            const OtherFile& other);
// The file in a folder that serves as calibration: by the usual names, else the only one of a known format. Empty =
// none; the folder itself = several, and reading it is an error that lists them.
std::string find_calibration(const std::string& folder);

// What is said where `recording`, a folder or a file in one, has none: names what lies there and cannot be read.
Error missing_calibration(const std::string& recording);

// Whether reading failed for want of the lens's name alone (CalibrationOptions::lens).
bool asks_for_lens(const Error& error);

}  // namespace cliquevo::drivers
