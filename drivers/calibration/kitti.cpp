// SPDX-License-Identifier: BSD-3-Clause
// KITTI's text files, and the data sets that write them alike: KITTI-360 (perspective.txt), DrivingStereo.
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

// Numbers behind "key:", `count` of them where it is given.
Result<std::vector<double>> numbers_of(const std::vector<TextLine>& lines, const std::string& key,
                                       std::optional<std::size_t> count, const std::string& path) {
  for (const TextLine& line : lines) {
    const std::size_t colon = line.text.find(':');
    if (colon == std::string_view::npos || trim(line.text.substr(0, colon)) != key) continue;
    const std::string where = fmt::format("{}:{}", path, line.number);
    Result<std::vector<double>> values = calibration_numbers(line.text.substr(colon + 1), where);
    if (values && count && values->size() != *count) {
      return Error{fmt::format("{} has {} numbers instead of {}", key, values->size(), *count), where,
                   "copy the calibration again: it is torn"};
    }
    return values;
  }
  return Error{fmt::format("calibration lacks {}", key), path, "copy it again or name the right file"};
}

struct Projection {
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  double shift_m = 0.0;  // x of the projection's origin in this camera
};

Result<Projection> projection_of(const std::vector<TextLine>& lines, const std::string& key, const std::string& path) {
  const Result<std::vector<double>> read = numbers_of(lines, key, 12, path);
  if (!read) return read.error();
  const std::vector<double>& p = *read;
  const std::string where = path + " (" + key + ")";
  if (p[0] <= 0.0 || p[5] <= 0.0) return calibration_error("projection is singular (focal length <= 0)", where);
  if (std::abs(p[1]) > 1e-6 * p[0] || p[4] != 0.0 || p[8] != 0.0 || p[9] != 0.0 || std::abs(p[10] - 1.0) > 1e-9) {
    return calibration_error("projection is not that of a rectified camera", where);
  }
  return Projection{p[0], p[5], p[2], p[6], p[3] / p[0]};
}

CameraCalibration pinhole(const Projection& p) {
  CameraCalibration camera;
  camera.fx_px = p.fx_px;
  camera.fy_px = p.fy_px;
  camera.cx_px = p.cx_px;
  camera.cy_px = p.cy_px;
  return camera;
}

// Both cameras by their projections; finish_calibration() finds that nothing needs warping where f and cy agree.
StereoCalibration pair_of(const Projection& left, const Projection& right) {
  StereoCalibration c;
  c.left = pinhole(left);
  c.right = pinhole(right);
  c.T_right_left.t = {right.shift_m - left.shift_m, 0.0, 0.0};
  return c;
}

Result<CameraCalibration> raw_camera(const std::vector<TextLine>& lines, const std::string& suffix,
                                     const std::string& path) {
  const Result<std::vector<double>> S = numbers_of(lines, "S_" + suffix, 2, path);
  if (!S) return S.error();
  const Result<std::vector<double>> K = numbers_of(lines, "K_" + suffix, 9, path);
  if (!K) return K.error();
  const Result<std::vector<double>> D = numbers_of(lines, "D_" + suffix, std::nullopt, path);
  if (!D) return D.error();
  CameraCalibration camera;
  for (const double side : *S) {
    if (side < 1.0 || side > 1e6)
      return calibration_error("image size is absurd", fmt::format("{} (S_{})", path, suffix));
  }
  camera.width = static_cast<int>(S.value()[0]);
  camera.height = static_cast<int>(S.value()[1]);
  if (const Result<void> ok = set_camera_matrix(*K, fmt::format("{} (K_{})", path, suffix), camera); !ok) {
    return ok.error();
  }
  if (const auto ok = set_distortion("", *D, fmt::format("{} (D_{})", path, suffix), camera); !ok) return ok.error();
  return camera;
}

// Pose of a camera against camera 0: p_cam = R p_0 + T.
Result<RigidTransform> raw_pose(const std::vector<TextLine>& lines, const std::string& suffix,
                                const std::string& path) {
  const Result<std::vector<double>> R = numbers_of(lines, "R_" + suffix, 9, path);
  if (!R) return R.error();
  const Result<std::vector<double>> T = numbers_of(lines, "T_" + suffix, 3, path);
  if (!T) return T.error();
  return RigidTransform{matrix3_from(*R), {T.value()[0], T.value()[1], T.value()[2]}};
}

Result<StereoCalibration> raw_rectified_part(const std::vector<TextLine>& lines, const std::string& l,
                                             const std::string& r, const std::string& path) {
  const Result<Projection> P_left = projection_of(lines, "P_rect_" + l, path);
  if (!P_left) return P_left.error();
  const Result<Projection> P_right = projection_of(lines, "P_rect_" + r, path);
  if (!P_right) return P_right.error();
  StereoCalibration c = pair_of(*P_left, *P_right);
  const Result<std::vector<double>> S = numbers_of(lines, "S_rect_" + l, 2, path);
  if (!S) return S.error();
  for (const double side : *S) {
    if (side < 1.0 || side > 1e6)
      return calibration_error("image size is absurd", fmt::format("{} (S_rect_{})", path, l));
  }
  c.left.width = c.right.width = static_cast<int>(S.value()[0]);
  c.left.height = c.right.height = static_cast<int>(S.value()[1]);
  return c;
}

// The numbers of the cameras in a file: "00", "101".
std::set<std::string> cameras_of(const std::vector<TextLine>& lines) {
  std::set<std::string> out;
  for (const TextLine& line : lines) {
    const std::string_view key = trim(line.text.substr(0, line.text.find(':')));
    const bool number = key.size() > 7 && key.find_first_not_of("0123456789", 7) == std::string_view::npos;
    if (number && key.substr(0, 7) == "P_rect_") out.insert(std::string(key.substr(7)));
  }
  return out;
}

struct CameraNames {
  std::string left;
  std::string right;
};

// The layout's cameras where the file has them, else the two that it has: the left one sees things farther right.
Result<CameraNames> camera_names(const CalibrationText& file, const CalibrationRequest& request) {
  CameraNames names{fmt::format("{:02}", request.left_camera), fmt::format("{:02}", request.right_camera)};
  const std::set<std::string> cameras = cameras_of(file.lines);
  if (cameras.count(names.left) + cameras.count(names.right) > 0 || cameras.size() != 2) return names;
  names = {*cameras.begin(), *std::next(cameras.begin())};
  const auto first = projection_of(file.lines, "P_rect_" + names.left, file.path);
  if (!first) return first.error();
  const auto second = projection_of(file.lines, "P_rect_" + names.right, file.path);
  if (!second) return second.error();
  if (second->shift_m > first->shift_m) std::swap(names.left, names.right);
  return names;
}

// Halved files of DrivingStereo keep the P[3] of the whole image: the baseline is that of T.
void mend_halved(double poses_m, StereoCalibration& rectified) {
  const double projected_m = -rectified.T_right_left.t.x();
  const double ratio = projected_m / poses_m;
  if (!(std::abs(ratio - 2.0) < 0.04 || std::abs(ratio - 0.5) < 0.01)) return;
  rectified.T_right_left.t.x() = -poses_m;
  rectified.notes.push_back(fmt::format(
      "P_rect makes a baseline of {:.4f} m, R and T one of {:.4f} m: the latter is taken", projected_m, poses_m));
}

}  // namespace

bool is_kitti_odometry(const CalibrationText& file) {
  if (file.document) return false;
  return file.has_line("P0") || file.has_line("P1") || file.has_line("P2") || file.has_line("P3");
}

bool is_kitti_raw(const CalibrationText& file) {
  if (file.document) return false;
  if (file.has_line("calib_time") || !cameras_of(file.lines).empty()) return true;
  for (const char* key : {"K_00", "S_00", "K_02", "S_02", "R_rect_00", "K_101", "S_101"}) {
    if (file.has_line(key)) return true;
  }
  return false;
}

Result<StereoCalibration> read_kitti_odometry(const CalibrationText& file, const CalibrationRequest& request,
                                              const OtherFile& /*other*/) {
  const Result<Projection> left = projection_of(file.lines, fmt::format("P{}", request.left_camera), file.path);
  if (!left) return left.error();
  const Result<Projection> right = projection_of(file.lines, fmt::format("P{}", request.right_camera), file.path);
  if (!right) return right.error();
  return finish_calibration(pair_of(*left, *right), request);
}

Result<StereoCalibration> read_kitti_raw(const CalibrationText& file, const CalibrationRequest& request,
                                         const OtherFile& /*other*/) {
  const std::vector<TextLine>& lines = file.lines;
  const std::string& path = file.path;
  const Result<CameraNames> names = camera_names(file, request);
  if (!names) return names.error();
  const std::string& l = names->left;
  const std::string& r = names->right;

  Result<StereoCalibration> rectified = raw_rectified_part(lines, l, r, path);
  if (!rectified) return rectified.error();
  const Result<RigidTransform> T_left_0 = raw_pose(lines, l, path);
  const Result<RigidTransform> T_right_0 = raw_pose(lines, r, path);
  if (T_left_0 && T_right_0) mend_halved((*T_right_0 * T_left_0->inverse()).t.norm(), *rectified);
  const CameraCalibration& image = rectified->left;
  if (!file.has_line("K_" + l) && image.width > 0) return finish_calibration(*rectified, request);
  const Result<CameraCalibration> left = raw_camera(lines, l, path);
  if (!left) return left.error();
  const Result<CameraCalibration> right = raw_camera(lines, r, path);
  if (!right) return right.error();
  const bool as_grabbed = request.width == 0 || (left->width == request.width && left->height == request.height);
  const bool as_rectified = image.width == request.width && image.height == request.height;
  if (as_rectified && (!as_grabbed || request.options.rectified)) return finish_calibration(*rectified, request);
  if (!as_grabbed) return size_error(path, left->width, left->height, request.width, request.height);
  if (!T_left_0) return T_left_0.error();
  if (!T_right_0) return T_right_0.error();

  StereoCalibration c;
  c.left = *left;
  c.right = *right;
  c.notes = rectified->notes;
  c.T_right_left = *T_right_0 * T_left_0->inverse();

  // The frame of R_rect and P_rect is the reference's: a rectification of our own would be turned against it.
  PrescribedRectification p;
  const Result<std::vector<double>> R_left = numbers_of(lines, "R_rect_" + l, 9, path);
  if (!R_left) return R_left.error();
  const Result<std::vector<double>> R_right = numbers_of(lines, "R_rect_" + r, 9, path);
  if (!R_right) return R_right.error();
  p.R_left = matrix3_from(*R_left);
  p.R_right = matrix3_from(*R_right);
  p.model.width = rectified->left.width;
  p.model.height = rectified->left.height;
  p.model.fx_px = rectified->left.fx_px;
  p.model.fy_px = rectified->left.fy_px;
  p.model.cx_px = rectified->left.cx_px;
  p.model.cy_px = rectified->left.cy_px;
  p.model.baseline_m = -rectified->T_right_left.t.x();
  p.model.doffs_px = rectified->right.cx_px - rectified->left.cx_px;
  const CameraCalibration& rr = rectified->right;
  if (std::abs(rr.fx_px - p.model.fx_px) > 1e-6 || std::abs(rr.fy_px - p.model.fy_px) > 1e-6 ||
      std::abs(rr.cy_px - p.model.cy_px) > 1e-6) {
    return calibration_error("P_rect of the cameras have unequal focal lengths or rows", path);
  }
  c.prescribed = p;
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
