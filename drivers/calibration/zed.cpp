// SPDX-License-Identifier: BSD-3-Clause
// Stereolabs' SN<number>.conf: the factory's calibration of a ZED, a section per camera and resolution; lengths in mm.
#include <array>
#include <cstdlib>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

struct Resolution {
  const char* name;
  int width;
  int height;
};
constexpr std::array<Resolution, 9> kResolutions{{{"HD", 1280, 720},
                                                  {"VGA", 672, 376},
                                                  {"FHD", 1920, 1080},
                                                  {"2K", 2208, 1242},
                                                  {"FHD1200", 1920, 1200},
                                                  {"SVGA", 960, 600},
                                                  {"QHDPLUS", 3200, 1800},
                                                  {"4K", 3840, 2160},
                                                  {"XVGA", 768, 480}}};

// The section for images of this size: its own, else one of the same aspect that can be scaled.
const Resolution* choose(const Document& file, const CalibrationRequest& request) {
  const Resolution* scaled = nullptr;
  for (const Resolution& r : kResolutions) {
    if (!file.has(std::string("LEFT_CAM_") + r.name)) continue;
    if (request.width <= 0 || (r.width == request.width && r.height == request.height)) return &r;
    if (scaled == nullptr && std::abs(r.width * request.height - r.height * request.width) < r.width) scaled = &r;
  }
  return scaled;
}

Result<CameraCalibration> read_camera(const Document& file, const std::string& section, const Resolution& resolution) {
  const auto values = file.inner(section);
  if (!values) return values.error();
  CameraCalibration camera;
  camera.width = resolution.width;
  camera.height = resolution.height;
  for (const auto& [key, target] :
       {std::pair{"fx", &camera.fx_px}, {"fy", &camera.fy_px}, {"cx", &camera.cx_px}, {"cy", &camera.cy_px}}) {
    const auto value = values->number(key);
    if (!value) return value.error();
    *target = *value;
  }
  std::vector<double> D;
  for (const char* key : {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}) {
    if (!values->has(key) && D.size() >= 5) break;
    D.push_back(0.0);
    if (!values->has(key)) continue;
    const auto value = values->number(key);
    if (!value) return value.error();
    D.back() = *value;
  }
  D.resize(D.size() > 5 ? 8 : 5);
  if (auto ok = set_distortion("", D, file.where(section), camera); !ok) return ok.error();
  return camera;
}

// A number of [STEREO], of this resolution where there is one for each.
Result<double> stereo_value(const Document& stereo, const std::string& key, const char* resolution) {
  const std::string own = key + "_" + resolution;
  if (stereo.has(own)) return stereo.number(own);
  return stereo.has(key) ? stereo.number(key) : Result<double>(0.0);
}

}  // namespace

bool is_zed(const CalibrationText& file) {
  if (!file.document || !file.has("STEREO")) return false;
  for (const auto& [name, node] : file.document->root().entries) {
    if (name.starts_with("LEFT_CAM_")) return true;
  }
  return false;
}

Result<StereoCalibration> read_zed(const CalibrationText& file, const CalibrationRequest& request,
                                   const OtherFile& /*other*/) {
  const Document& document = *file.document;
  const Resolution* resolution = choose(document, request);
  if (resolution == nullptr) {
    return Error{"calibration is of another image size", file.path,
                 fmt::format("it has no section for images of {}x{}: record in one of the camera's own resolutions",
                             request.width, request.height)};
  }
  StereoCalibration c;
  const auto left = read_camera(document, std::string("LEFT_CAM_") + resolution->name, *resolution);
  if (!left) return left.error();
  const auto right = read_camera(document, std::string("RIGHT_CAM_") + resolution->name, *resolution);
  if (!right) return right.error();
  c.left = *left;
  c.right = *right;
  const auto stereo = document.inner("STEREO");
  if (!stereo) return stereo.error();
  Eigen::Vector3d turn, place_mm;
  int axis = 0;
  for (const char* key : {"RX", "CV", "RZ"}) {
    const auto value = stereo_value(*stereo, key, resolution->name);
    if (!value) return value.error();
    turn[axis++] = *value;
  }
  if (turn.norm() > 1.0) return calibration_error("turn between the cameras is absurd", document.where("STEREO"));
  const auto baseline_mm = stereo->number("Baseline");
  if (!baseline_mm) return baseline_mm.error();
  const auto y_mm = stereo_value(*stereo, "TY", resolution->name);
  if (!y_mm) return y_mm.error();
  const auto z_mm = stereo_value(*stereo, "TZ", resolution->name);
  if (!z_mm) return z_mm.error();
  // Baseline, TY and TZ have the sign of the right camera's place.
  place_mm = {*baseline_mm, *y_mm, *z_mm};
  c.T_right_left.R = so3_exp(turn);
  c.T_right_left.t = -0.001 * place_mm;
  return finish_calibration(c, request, 0.001);
}

}  // namespace cliquevo::drivers
