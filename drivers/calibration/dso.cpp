// SPDX-License-Identifier: BSD-3-Clause
// DSO's cameras: its stereo variants' five lines, and 4Seasons' files, one per camera.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

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
    return Error{"calibration is of no known format or camera model", where, "use Pinhole, RadTan or EquiDistant"};
  }
  const Result<std::vector<double>> numbers = calibration_numbers(rest, where);
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
    return Error{"calibration is of no known format", where, "use Pinhole, RadTan or EquiDistant"};
  }
  // Behind the four is the FOV model's parameter, 0 here; 4Seasons fills up with zeros.
  const bool pinhole_tail = name == "Pinhole" && (v.size() == 5 || v.size() == 8);
  if (pinhole_tail && std::any_of(v.begin() + 4, v.end(), [](double x) { return x != 0.0; })) {
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
  Result<std::vector<double>> numbers = calibration_numbers(line.text, where);
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

void to_pixels(CameraCalibration& c) {
  if (c.cx_px >= 1.0 || c.cy_px >= 1.0) return;
  c.fx_px *= c.width;  // relative to the size; DSO puts the pixel's centre at 0.5
  c.fy_px *= c.height;
  c.cx_px = c.cx_px * c.width - 0.5;
  c.cy_px = c.cy_px * c.height - 0.5;
}

// "calib_0.txt" to "calib_1.txt" and so on, whichever it is.
std::string sibling(const std::string& path, const char* which) {
  for (const char* name : {"calib_0", "calib_1", "calib_stereo"}) {
    std::string out = replaced(path, name, std::string("calib_") + which, 1);
    if (!out.empty()) return out;
  }
  return {};
}

Result<CameraCalibration> read_camera(const NamedText& file) {
  const std::vector<TextLine> lines = split_lines(file.text);
  if (lines.size() < 2) {
    return Error{"calibration has no camera and size", file.path, "copy it again"};
  }
  Result<CameraCalibration> camera = parse_camera(lines[0], fmt::format("{}:{}", file.path, lines[0].number));
  if (!camera) return camera;
  if (auto ok = read_size(lines[1], "image size", file.path, camera->width, camera->height); !ok) return ok.error();
  to_pixels(*camera);
  return camera;
}

bool is_camera_line(std::string_view line) {
  if (is_word(line)) {
    const std::string_view name = split_words(line).front();
    return name == "Pinhole" || name == "RadTan" || name == "EquiDistant" || name == "KannalaBrandt" || name == "FOV" ||
           name == "UniversalOmni";
  }
  const auto numbers = parse_numbers(line, "calibration", "");
  return numbers && (numbers->size() == 5 || numbers->size() == 8);
}

}  // namespace

bool is_four_seasons(const CalibrationText& file) {
  const std::string name = file.name();
  for (const char* known : {"calib_0.txt", "calib_1.txt"}) {
    if (name.find(known) != std::string::npos && file.lines.size() < 5 && !file.lines.empty() &&
        is_camera_line(file.lines.front().text)) {
      return true;
    }
  }
  if (name.find("calib_stereo.txt") == std::string::npos || file.lines.size() < 3) return false;
  const auto row = parse_numbers(file.lines.front().text, "calibration", "");
  return row && row->size() == 4;
}

Result<StereoCalibration> read_four_seasons(const CalibrationText& file, const CalibrationRequest& request,
                                            const OtherFile& other) {
  StereoCalibration c;
  for (const char* number : {"0", "1"}) {
    const auto text = other({sibling(file.path, number)});
    if (!text) return text.error();
    const auto camera = read_camera(*text);
    if (!camera) return camera.error();
    (*number == '0' ? c.left : c.right) = *camera;
  }
  const auto stereo = other({sibling(file.path, "stereo")});
  if (!stereo) return stereo.error();
  std::vector<double> numbers;
  for (const TextLine& line : split_lines(stereo->text)) {
    const auto row = calibration_numbers(line.text, fmt::format("{}:{}", stereo->path, line.number));
    if (!row) return row.error();
    numbers.insert(numbers.end(), row->begin(), row->end());
  }
  const auto T = transform_from(numbers, stereo->path);
  if (!T) return T.error();
  // From the right camera to the left one; the other way round the right camera would lie left.
  c.T_right_left = T->t.x() > 0.0 ? T->inverse() : *T;
  return finish_calibration(c, request);
}

bool is_dso(const CalibrationText& file) {
  if (file.document || file.broken || file.lines.empty() || !is_camera_line(file.lines.front().text)) return false;
  if (is_word(file.lines.front().text)) return true;
  // Tables of poses have rows of eight numbers, too: the size must follow.
  const auto size = file.lines.size() > 1 ? parse_numbers(file.lines[1].text, "calibration", "") : Error{};
  return size && size->size() == 2;
}

Result<StereoCalibration> read_dso(const CalibrationText& file, const CalibrationRequest& request,
                                   const OtherFile& /*other*/) {
  const std::vector<TextLine>& lines = file.lines;
  const std::string& path = file.path;
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
  to_pixels(c.left);
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
