// SPDX-License-Identifier: BSD-3-Clause
// VINS-Fusion: a main file with body_T_cam0 and body_T_cam1, which names camodocal's file of each camera.
#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"
#include "drivers/calibration/keys.h"

namespace cliquevo::drivers {

namespace {

Result<std::vector<double>> terms(const Document& map, std::initializer_list<const char*> keys) {
  std::vector<double> out;
  for (const char* key : keys) {
    const auto value = map.number(key);
    if (!value) return value.error();
    out.push_back(*value);
  }
  return out;
}

Result<CameraCalibration> read_vins_camera(const Document& file) {
  CameraCalibration camera;
  const std::string model = file.word("model_type");
  const auto projection = file.inner("projection_parameters");
  if (!projection) return projection.error();
  std::vector<double> K;
  std::vector<double> D;
  std::string name;
  const auto take = [](Result<std::vector<double>> read, std::vector<double>& into) -> Result<void> {
    if (!read) return read.error();
    into.insert(into.end(), read->begin(), read->end());
    return {};
  };
  const auto distortion = [&]() -> Result<void> {
    const auto map = file.inner("distortion_parameters");
    if (!map) return map.error();
    return take(terms(*map, {"k1", "k2", "p1", "p2"}), D);
  };
  Result<void> ok;
  if (model == "PINHOLE") {
    name = "radtan";
    ok = take(terms(*projection, {"fx", "fy", "cx", "cy"}), K);
    if (ok) ok = distortion();
  } else if (model == "MEI") {
    name = "omni";
    ok = take(terms(*projection, {"gamma1", "gamma2", "u0", "v0"}), K);
    const auto mirror = file.inner("mirror_parameters");
    if (!mirror) return mirror.error();
    if (ok) ok = take(terms(*mirror, {"xi"}), D);
    if (ok) ok = distortion();
  } else if (model == "KANNALA_BRANDT") {
    name = "equidistant";
    ok = take(terms(*projection, {"mu", "mv", "u0", "v0"}), K);
    if (ok) ok = take(terms(*projection, {"k2", "k3", "k4", "k5"}), D);
  } else {
    return Error{"camera model " + printable(model.substr(0, 32)) + " is not known", file.where("model_type"),
                 "calibrate as PINHOLE, MEI or KANNALA_BRANDT"};
  }
  if (!ok) return ok.error();
  camera.fx_px = K[0];
  camera.fy_px = K[1];
  camera.cx_px = K[2];
  camera.cy_px = K[3];
  if (auto set = set_distortion(name, D, file.where("model_type"), camera); !set) return set.error();
  if (auto sized = set_image_size(file, camera); !sized) return sized.error();
  return camera;
}

}  // namespace

bool is_vins(const CalibrationText& file) {
  if (!file.has("body_T_cam0") && !file.has("cam0_calib")) return false;
  return file.has("cam0_calib") || !Keys(*file.document).has(Quantity::fx, KeySide::right);  // OV2SLAM has both in one
}

Result<StereoCalibration> read_vins(const CalibrationText& file, const CalibrationRequest& request,
                                    const OtherFile& other) {
  StereoCalibration c;
  RigidTransform T_body_camera[2];
  for (int side = 0; side < 2; ++side) {
    const std::string pose = fmt::format("body_T_cam{}", side);
    const auto T = file.document->transform(pose);
    if (!T) return T.error();
    T_body_camera[side] = *T;
    const std::string key = fmt::format("cam{}_calib", side);
    const std::string name = file.document->word(key);
    if (name.empty() || name.front() == '/' || name.find("..") != std::string::npos || printable(name) != name) {
      return Error{"calibration names no file of intrinsics", file.document->where(key),
                   "name the file beside this one that has them"};
    }
    const auto document = read_other(other, {beside(file.path, name)});
    if (!document) return document.error();
    const auto camera = read_vins_camera(*document);
    if (!camera) return camera.error();
    (side == 0 ? c.left : c.right) = *camera;
  }
  c.T_right_left = T_body_camera[1].inverse() * T_body_camera[0];
  order_cameras(c);
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
