// SPDX-License-Identifier: BSD-3-Clause
// Tells the calibration formats apart by what is in the file.
#include "drivers/calibration_file.h"

#include <array>
#include <filesystem>

#include "drivers/recording/calibration_common.h"
#include "drivers/recording/dso_calibration.h"
#include "drivers/recording/kitti_calibration.h"
#include "drivers/recording/text_file.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1U << 20U;

// In a folder: the first of these that exists.
constexpr std::array<const char*, 5> kFileNames{"calib_cam_to_cam.txt", "calib.txt", "calib_stereo.txt", "camera.txt",
                                                "calibration.txt"};

bool has_key(const std::vector<TextLine>& lines, std::string_view key) {
  for (const TextLine& line : lines) {
    if (line.text.substr(0, key.size()) == key && trim(line.text.substr(key.size())).substr(0, 1) == ":") return true;
  }
  return false;
}

Result<StereoCalibration> parse_text(const std::string& text, const CalibrationRequest& request) {
  const std::vector<TextLine> lines = split_lines(text);
  for (const char* key : {"K_00", "S_00", "K_02", "S_02", "calib_time", "R_rect_00", "P_rect_00"}) {
    if (has_key(lines, key)) return parse_kitti_raw(text, request);
  }
  for (const char* key : {"P0", "P1", "P2", "P3"}) {
    if (has_key(lines, key)) return parse_kitti_odometry(text, request);
  }
  return parse_dso(text, request);
}

}  // namespace

Result<StereoCalibration> read_calibration(const CalibrationRequest& request) {
  std::error_code ec;
  if (fs::is_directory(request.path, ec)) {
    for (const char* name : kFileNames) {
      const fs::path file = fs::path(request.path) / name;
      if (!fs::exists(file, ec)) continue;
      CalibrationRequest inner = request;
      inner.path = file.string();
      return read_calibration(inner);
    }
    return Error{"no calibration", request.path, "name the file with --calibration"};
  }
  const Result<std::string> text = read_text_file(request.path, "calibration", kMostBytes);
  if (!text) return text.error();
  return parse_text(*text, request);
}

Result<StereoCalibration> read_calibration(const std::string& path, int width, int height) {
  CalibrationRequest request;
  request.path = path;
  request.width = width;
  request.height = height;
  return read_calibration(request);
}

}  // namespace cliquevo::drivers
