// SPDX-License-Identifier: BSD-3-Clause
// Middlebury's calib.txt: rectified pairs, matrices in brackets, the baseline in mm, sizes.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

struct Value {
  std::string where;
  std::string text;
};

// What stands behind "key=", without brackets and semicolons.
std::optional<Value> value_of(const CalibrationText& file, std::string_view key) {
  for (const TextLine& line : file.lines) {
    const std::size_t equals = line.text.find('=');
    if (equals == std::string_view::npos || trim(line.text.substr(0, equals)) != key) continue;
    Value out{fmt::format("{}:{} ({})", file.path, line.number, key), std::string(line.text.substr(equals + 1))};
    std::replace_if(
        out.text.begin(), out.text.end(), [](char c) { return c == '[' || c == ']' || c == ';'; }, ' ');
    return out;
  }
  return std::nullopt;
}

Result<std::vector<double>> numbers(const CalibrationText& file, const char* key, std::size_t count) {
  const std::optional<Value> value = value_of(file, key);
  if (!value) return Error{fmt::format("calibration lacks {}", key), file.path, "copy it again or name the right file"};
  Result<std::vector<double>> out = calibration_numbers(value->text, value->where);
  if (out && out->size() != count) {
    return Error{fmt::format("{} has {} numbers instead of {}", key, out->size(), count), value->where,
                 "copy the calibration again: it is torn"};
  }
  return out;
}

}  // namespace

bool is_middlebury(const CalibrationText& file) {
  const auto cam0 = value_of(file, "cam0");
  return cam0 && value_of(file, "cam1") && file.text.find('[') != std::string::npos;
}

Result<StereoCalibration> read_middlebury(const CalibrationText& file, const CalibrationRequest& request,
                                          const OtherFile& /*other*/) {
  StereoCalibration c;
  const auto width = numbers(file, "width", 1);
  if (!width) return width.error();
  const auto height = numbers(file, "height", 1);
  if (!height) return height.error();
  const auto size = size_from(width->front(), height->front(), file.path + " (width, height)");
  if (!size) return size.error();
  for (const char* key : {"cam0", "cam1"}) {
    CameraCalibration& camera = key[3] == '0' ? c.left : c.right;
    const auto K = numbers(file, key, 9);
    if (!K) return K.error();
    if (auto ok = set_camera_matrix(*K, fmt::format("{} ({})", file.path, key), camera); !ok) return ok.error();
    camera.width = size->first;
    camera.height = size->second;
  }
  const auto baseline_mm = numbers(file, "baseline", 1);
  if (!baseline_mm) return baseline_mm.error();
  if (value_of(file, "doffs")) {
    const auto doffs = numbers(file, "doffs", 1);
    if (!doffs) return doffs.error();
    if (std::abs(doffs->front() - (c.right.cx_px - c.left.cx_px)) > 1.0) {
      return calibration_error("doffs does not fit the principal points", file.path);
    }
  }
  c.T_right_left.t = {-0.001 * baseline_mm->front(), 0.0, 0.0};
  return finish_calibration(c, request, 0.001);
}

}  // namespace cliquevo::drivers
