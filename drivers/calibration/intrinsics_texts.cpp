// SPDX-License-Identifier: BSD-3-Clause
// Texts of bare numbers: FoundationStereo's K.txt, and the camera models of RobotCar's tools.
#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

// Numbers in a line; empty = it holds others.
std::vector<double> numbers_in(const TextLine& line) {
  const auto numbers = parse_numbers(line.text, "calibration", "");
  return numbers ? *numbers : std::vector<double>{};
}

struct ImageCamera {
  CameraCalibration camera;
  RigidTransform T_camera_image;  // from the image's axes (Z forward) to the rig's
};

Result<ImageCamera> read_camera_model(const std::string& text, const std::string& path) {
  const std::vector<TextLine> lines = split_lines(text);
  if (lines.size() != 5) return Error{"camera model has no 5 lines", path, "copy it again"};
  ImageCamera out;
  std::vector<double> rows;
  for (const TextLine& line : lines) {
    const auto numbers = calibration_numbers(line.text, fmt::format("{}:{}", path, line.number));
    if (!numbers) return numbers.error();
    rows.insert(rows.end(), numbers->begin(), numbers->end());
  }
  if (rows.size() != 20) return Error{"camera model has no 20 numbers", path, "copy it again"};
  if (auto ok = set_camera_matrix({rows[0], 0, rows[2], 0, rows[1], rows[3], 0, 0, 1}, path, out.camera); !ok) {
    return ok.error();
  }
  const auto T = transform_from({rows.begin() + 4, rows.end()}, path);
  if (!T) return T.error();
  out.T_camera_image = *T;
  return out;
}

}  // namespace

bool is_foundation_stereo(const CalibrationText& file) {
  if (file.document || file.broken || file.lines.size() != 2) return false;
  const std::vector<double> K = numbers_in(file.lines[0]);
  return K.size() == 9 && K[8] == 1.0 && numbers_in(file.lines[1]).size() == 1;
}

Result<StereoCalibration> read_foundation_stereo(const CalibrationText& file, const CalibrationRequest& request,
                                                 const OtherFile& /*other*/) {
  StereoCalibration c;
  const std::string where = file.path + ":1";
  if (auto ok = set_camera_matrix(numbers_in(file.lines[0]), where, c.left); !ok) return ok.error();
  c.right = c.left;
  c.T_right_left.t.x() = -numbers_in(file.lines[1]).front();
  return finish_calibration(c, request);
}

bool is_robotcar(const CalibrationText& file) {
  if (file.document || file.broken || file.lines.size() != 5) return false;
  for (const TextLine& line : file.lines) {
    if (numbers_in(line).size() != 4) return false;
  }
  return numbers_in(file.lines[4]) == std::vector<double>{0.0, 0.0, 0.0, 1.0};
}

Result<StereoCalibration> read_robotcar(const CalibrationText& file, const CalibrationRequest& request,
                                        const OtherFile& other) {
  const auto second = other(other_camera_paths(file.path));
  if (!second) return second.error();
  const auto one = read_camera_model(file.text, file.path);
  if (!one) return one.error();
  const auto two = read_camera_model(second->text, second->path);
  if (!two) return two.error();
  const bool swapped = is_right_of(file.path, second->path);
  const ImageCamera& left = swapped ? *two : *one;
  const ImageCamera& right = swapped ? *one : *two;
  StereoCalibration c;
  c.left = left.camera;
  c.right = right.camera;
  c.T_right_left = right.T_camera_image.inverse() * left.T_camera_image;
  if (c.T_right_left.t.x() > 0.0) c.T_right_left = c.T_right_left.inverse();  // the order is in their names
  c.notes.emplace_back("the camera models are those of undistorted images");
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
