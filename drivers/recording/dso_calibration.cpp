// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/dso_calibration.h"

#include <algorithm>

#include <fmt/format.h>

#include "drivers/recording/text_file.h"

namespace cliquevo::drivers {

namespace {

bool is_word(std::string_view text) {
  return !text.empty() &&
         ((text.front() >= 'A' && text.front() <= 'Z') || (text.front() >= 'a' && text.front() <= 'z'));
}

// "Pinhole fx fy cx cy 0", or without the word: 5 numbers with a last 0 are a pinhole, 8 are radial-tangential.
Result<CameraCalibration> parse_camera(const TextLine& line, const std::string& where) {
  std::string_view rest = line.text;
  std::string_view name;
  if (is_word(rest)) {
    name = split_words(rest).front();
    rest.remove_prefix(name.size());
  }
  const auto known = {"Pinhole", "RadTan", "EquiDistant", "KannalaBrandt"};
  if (!name.empty() && std::find(known.begin(), known.end(), name) == known.end()) {
    return Error{"calibration is of no known format or camera model", where,
                 "name a KITTI, EuRoC, Kalibr, ROS, OpenCV or DSO file (Pinhole, RadTan or EquiDistant)"};
  }
  const Result<std::vector<double>> numbers = parse_numbers(rest, "calibration", where);
  if (!numbers) return numbers.error();
  const std::vector<double>& v = *numbers;
  if (name.empty() && v.size() == 5) name = "Pinhole";
  if (name.empty() && v.size() == 8) name = "RadTan";

  CameraCalibration camera;
  std::size_t coefficients = 0;
  if (name == "Pinhole") {
    camera.distortion = Distortion::none;
  } else if (name == "RadTan") {
    camera.distortion = Distortion::plumb_bob;
    coefficients = 4;
  } else if (name == "EquiDistant" || name == "KannalaBrandt") {
    camera.distortion = Distortion::equidistant;
    coefficients = 4;
  } else {
    return Error{"calibration is of no known format", where, "name a KITTI, EuRoC, Kalibr, ROS, OpenCV or DSO file"};
  }
  const bool pinhole_tail = name == "Pinhole" && v.size() == 5;  // the fifth is the FOV model's parameter, 0 here
  if (pinhole_tail && v[4] != 0.0) {
    return Error{"calibration is of the FOV camera model, which is not known", where,
                 "use Pinhole, RadTan or EquiDistant"};
  }
  if (v.size() != 4 + coefficients && !pinhole_tail) {
    return Error{fmt::format("camera has {} numbers instead of {}", v.size(), 4 + coefficients), where,
                 "copy the calibration again: it is torn"};
  }
  camera.fx_px = v[0];
  camera.fy_px = v[1];
  camera.cx_px = v[2];
  camera.cy_px = v[3];
  for (std::size_t i = 0; i < coefficients; ++i) camera.coefficients[i] = v[4 + i];
  return camera;
}

Result<std::vector<double>> exactly(const TextLine& line, std::size_t count, const char* what,
                                    const std::string& path) {
  const std::string where = fmt::format("{}:{}", path, line.number);
  Result<std::vector<double>> numbers = parse_numbers(line.text, "calibration", where);
  if (numbers && numbers->size() != count) {
    return Error{fmt::format("{} has {} numbers instead of {}", what, numbers->size(), count), where,
                 "copy the calibration again: it is torn"};
  }
  return numbers;
}

Result<void> read_size(const TextLine& line, const char* what, const std::string& path, int& width, int& height) {
  const Result<std::vector<double>> size = exactly(line, 2, what, path);
  if (!size) return size.error();
  for (const double side : *size) {
    if (side < 16.0 || side > 16384.0) {
      return calibration_error(fmt::format("{} is absurd", what), fmt::format("{}:{}", path, line.number));
    }
  }
  width = static_cast<int>(size.value()[0]);
  height = static_cast<int>(size.value()[1]);
  return {};
}

}  // namespace

Result<StereoCalibration> parse_dso(std::string_view text, const CalibrationRequest& request) {
  const std::vector<TextLine> lines = split_lines(text);
  const std::string& path = request.path;
  if (lines.empty()) return Error{"calibration is empty", path, "copy it again"};
  const Result<CameraCalibration> camera = parse_camera(lines[0], fmt::format("{}:{}", path, lines[0].number));
  if (!camera) return camera.error();
  if (lines.size() < 5) {
    return Error{fmt::format("calibration ends after {} of 5 lines", lines.size()), path,
                 "a stereo file has camera, size, mode, output size and baseline: copy it again"};
  }
  StereoCalibration c;
  c.left = *camera;
  if (const Result<void> ok = read_size(lines[1], "image size", path, c.left.width, c.left.height); !ok) {
    return ok.error();
  }
  if (c.left.cx_px < 1.0 && c.left.cy_px < 1.0) {  // relative to the size; DSO puts the pixel's centre at 0.5
    c.left.fx_px *= c.left.width;
    c.left.fy_px *= c.left.height;
    c.left.cx_px = c.left.cx_px * c.left.width - 0.5;
    c.left.cy_px = c.left.cy_px * c.left.height - 0.5;
  }
  c.right = c.left;
  int out_width = 0;
  int out_height = 0;
  if (const Result<void> ok = read_size(lines[3], "output size", path, out_width, out_height); !ok) return ok.error();
  const Result<std::vector<double>> baseline = exactly(lines[4], 1, "baseline", path);
  if (!baseline) return baseline.error();
  c.T_right_left.t = {-baseline.value()[0], 0.0, 0.0};

  // crop, full and none choose DSO's own working camera; a camera given in numbers is one to rectify to.
  const std::string_view mode = lines[2].text;
  if (mode != "crop" && mode != "full" && mode != "none") {
    if (is_word(mode)) {
      return Error{"rectification mode is not known", fmt::format("{}:{}", path, lines[2].number),
                   "use crop, full, none or the five numbers of the output camera"};
    }
    const Result<std::vector<double>> out = exactly(lines[2], 5, "output camera", path);
    if (!out) return out.error();
    const std::vector<double>& v = *out;
    const bool relative = v[2] < 1.0 && v[3] < 1.0;
    PrescribedRectification p;
    p.model.width = out_width;
    p.model.height = out_height;
    p.model.fx_px = relative ? v[0] * out_width : v[0];
    p.model.fy_px = relative ? v[1] * out_height : v[1];
    p.model.cx_px = relative ? v[2] * out_width - 0.5 : v[2];
    p.model.cy_px = relative ? v[3] * out_height - 0.5 : v[3];
    p.model.baseline_m = baseline.value()[0];
    c.prescribed = p;
  }
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
