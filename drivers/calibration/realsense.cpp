// SPDX-License-Identifier: BSD-3-Clause
// What librealsense's `rs-enumerate-devices -c` prints: a block of intrinsics per stream and resolution, and the pose
// from each stream to each other one, in metres.
#include <algorithm>
#include <array>
#include <cstdlib>

#include <fmt/format.h>

#include "drivers/calibration/camera_parts.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

constexpr std::array<std::array<const char*, 2>, 2> kPairs{{{"Infrared 1", "Infrared 2"}, {"Fisheye 1", "Fisheye 2"}}};
constexpr std::string_view kIntrinsic = "Intrinsic of ";
constexpr std::string_view kExtrinsic = "Extrinsic from ";

std::string quoted(const char* stream) { return fmt::format("\"{}\"", stream); }

bool is_intrinsic(const TextLine& line, const char* stream) {
  return line.text.starts_with(kIntrinsic) && line.text.substr(kIntrinsic.size()).starts_with(quoted(stream));
}

// The streams that the text has: none without one of the left cameras.
const std::array<const char*, 2>* pair_in(const CalibrationText& file) {
  for (const auto& pair : kPairs) {
    for (const TextLine& line : file.lines) {
      if (is_intrinsic(line, pair[0])) return &pair;
    }
  }
  return nullptr;
}

// What stands behind "key:" between line `from` and the next block; nullptr = nothing.
const TextLine* line_of(const CalibrationText& file, std::size_t from, std::string_view key) {
  for (std::size_t i = from + 1; i < file.lines.size(); ++i) {
    const std::string_view text = file.lines[i].text;
    if (text.starts_with(kIntrinsic) || text.starts_with(kExtrinsic)) break;
    if (text.starts_with(key)) return &file.lines[i];
  }
  return nullptr;
}

Error torn(std::string_view key, const std::string& where) {
  return {fmt::format("calibration lacks {}", key), where, "save the output of rs-enumerate-devices -c again"};
}

Result<std::vector<double>> numbers_of(const CalibrationText& file, std::size_t from, std::string_view key) {
  const TextLine* line = line_of(file, from, key);
  if (line == nullptr) return torn(key, fmt::format("{}:{}", file.path, file.lines[from].number));
  return calibration_numbers(line->text.substr(key.size()), fmt::format("{}:{} ({})", file.path, line->number, key));
}

Result<double> number_of(const CalibrationText& file, std::size_t from, std::string_view key) {
  const auto numbers = numbers_of(file, from, key);
  if (!numbers) return numbers.error();
  if (numbers->size() != 1) return torn(key, fmt::format("{}:{}", file.path, file.lines[from].number));
  return numbers->front();
}

Result<CameraParts> read_block(const CalibrationText& file, std::size_t from) {
  CameraParts parts;
  parts.where = fmt::format("{}:{}", file.path, file.lines[from].number);
  parts.D_where = parts.where;
  std::array<double, 6> values{};
  constexpr std::array<std::string_view, 6> kKeys{"Width:", "Height:", "Fx:", "Fy:", "PPX:", "PPY:"};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = number_of(file, from, kKeys[i]);
    if (!value) return value.error();
    values[i] = *value;
  }
  const auto size = size_from(values[0], values[1], parts.where);
  if (!size) return size.error();
  parts.camera.width = size->first;
  parts.camera.height = size->second;
  parts.camera.fx_px = values[2];
  parts.camera.fy_px = values[3];
  parts.camera.cx_px = values[4];
  parts.camera.cy_px = values[5];
  const auto coefficients = numbers_of(file, from, "Coeffs:");
  if (!coefficients) return coefficients.error();
  parts.D = *coefficients;
  const TextLine* lens = line_of(file, from, "Distortion:");
  // Rectified streams have a model and no terms.
  const bool straight = std::all_of(parts.D.begin(), parts.D.end(), [](double term) { return term == 0.0; });
  parts.lens = straight || lens == nullptr ? "none" : std::string(trim(lens->text.substr(11)));
  return parts;
}

// The block of a stream for images of the request's size: its own, else one of the same aspect, which can be scaled.
Result<CameraParts> read_camera(const CalibrationText& file, const char* stream, const CalibrationRequest& request) {
  std::optional<CameraParts> scaled;
  std::string sizes;
  for (std::size_t i = 0; i < file.lines.size(); ++i) {
    if (!is_intrinsic(file.lines[i], stream)) continue;
    auto parts = read_block(file, i);
    if (!parts) return parts.error();
    const int width = parts->camera.width, height = parts->camera.height;
    if (request.width <= 0 || (width == request.width && height == request.height)) return parts;
    sizes += fmt::format("{}{}x{}", sizes.empty() ? "" : ", ", width, height);
    const bool alike = std::abs(width * request.height - height * request.width) < width;
    if (alike && (!scaled || width > scaled->camera.width)) scaled = std::move(*parts);
  }
  if (scaled) return std::move(*scaled);
  if (sizes.empty()) return torn(quoted(stream), file.path);
  return Error{
      fmt::format("calibration has no block of {} for images of {}x{}", quoted(stream), request.width, request.height),
      file.path, fmt::format("record in one of its sizes: {}", sizes)};
}

Result<RigidTransform> read_pose(const CalibrationText& file, const std::array<const char*, 2>& pair) {
  for (std::size_t i = 0; i + 3 < file.lines.size(); ++i) {
    const std::string_view text = file.lines[i].text;
    if (!text.starts_with(std::string(kExtrinsic) + quoted(pair[0]))) continue;
    if (text.substr(kExtrinsic.size() + quoted(pair[0]).size()).find(quoted(pair[1])) == std::string_view::npos)
      continue;
    std::vector<double> R;
    const TextLine* title = line_of(file, i, "Rotation Matrix:");
    for (std::size_t row = 0; title != nullptr && row < 3; ++row) {
      const TextLine* line = title + 1 + row;
      if (line >= file.lines.data() + file.lines.size()) break;
      const auto numbers = calibration_numbers(line->text, fmt::format("{}:{}", file.path, line->number));
      if (!numbers) return numbers.error();
      R.insert(R.end(), numbers->begin(), numbers->end());
    }
    if (R.size() != 9) return torn("Rotation Matrix", fmt::format("{}:{}", file.path, file.lines[i].number));
    const auto t = numbers_of(file, i, "Translation Vector:");
    if (!t) return t.error();
    if (t->size() != 3) return torn("Translation Vector", fmt::format("{}:{}", file.path, file.lines[i].number));
    return RigidTransform{matrix3_from(R), {(*t)[0], (*t)[1], (*t)[2]}};
  }
  return torn(fmt::format("the extrinsics from {} to {}", quoted(pair[0]), quoted(pair[1])), file.path);
}

}  // namespace

bool is_realsense(const CalibrationText& file) { return pair_in(file) != nullptr; }

Result<StereoCalibration> read_realsense(const CalibrationText& file, const CalibrationRequest& request,
                                         const OtherFile& /*other*/) {
  const auto& pair = *pair_in(file);
  auto left = read_camera(file, pair[0], request);
  if (!left) return left.error();
  CalibrationRequest of_left = request;  // both cameras in one size
  of_left.width = left->camera.width;
  of_left.height = left->camera.height;
  auto right = read_camera(file, pair[1], of_left);
  if (!right) return right.error();
  const auto pose = read_pose(file, pair);
  if (!pose) return pose.error();
  return rig_of_pose(std::move(*left), std::move(*right), *pose, request);
}

}  // namespace cliquevo::drivers
