// SPDX-License-Identifier: BSD-3-Clause
// AirSLAM's cameras: the lens as a number for both, each camera's pose T with a number for its direction.
#include <array>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

// The rig but for its pose, and T of each camera.
struct AirCameras {
  StereoCalibration rig;
  std::array<RigidTransform, 2> T;
};

Result<std::string> air_lens(const Document& file, const Document& camera) {
  if (camera.has("distortion_model")) return camera.word("distortion_model");
  const auto type = file.number("distortion_type");
  if (!type) return type.error();
  if (*type == 0.0) return std::string("none");  // the images are undistorted, whatever coefficients stand there
  if (*type == 1.0) return std::string("radtan");
  if (*type == 2.0) return std::string("equidistant");
  return Error{fmt::format("distortion_type {:g} is not known", *type), file.where("distortion_type"),
               "give 0 (undistorted), 1 (radtan) or 2 (equidistant)"};
}

Result<CameraCalibration> read_air_camera(const Document& file, const Document& yaml) {
  CameraCalibration camera;
  const auto K = yaml.numbers("intrinsics", 4);
  if (!K) return K.error();
  const auto lens = air_lens(file, yaml);
  if (!lens) return lens.error();
  std::vector<double> D;
  const std::string key = yaml.first_of({"distortion_coeffs", "distortion_coefficients"});
  if (!key.empty() && *lens != "none") {
    const auto read = yaml.numbers(key);
    if (!read) return read.error();
    D = *read;
    if (D.size() == 5 && D.back() == 0.0) D.pop_back();  // five for every lens
  }
  if (auto ok =
          set_camera_matrix({(*K)[0], 0, (*K)[2], 0, (*K)[1], (*K)[3], 0, 0, 1}, yaml.where("intrinsics"), camera);
      !ok) {
    return ok.error();
  }
  if (auto ok = set_distortion(*lens, D, key.empty() ? yaml.path() : yaml.where(key), camera); !ok) return ok.error();
  if (auto ok = set_image_size(file, camera); !ok) return ok.error();
  return camera;
}

Result<AirCameras> read_air_cameras(const Document& file) {
  AirCameras out;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto yaml = file.inner(fmt::format("cam{}", side));
    if (!yaml) return yaml.error();
    const auto camera = read_air_camera(file, *yaml);
    if (!camera) return camera.error();
    (side == 0 ? out.rig.left : out.rig.right) = *camera;
    const auto T = yaml->transform("T");
    if (!T) return T.error();
    out.T[side] = *T;
  }
  return out;
}

}  // namespace

bool is_airslam(const CalibrationText& file) {
  if (!file.document) return false;
  for (const char* name : {"cam0", "cam1"}) {
    const DocumentNode* camera = file.document->root().find(name);
    if (camera == nullptr || camera->find("intrinsics") == nullptr || camera->find("T") == nullptr) return false;
  }
  return true;
}

Result<StereoCalibration> read_airslam(const CalibrationText& file, const CalibrationRequest& request,
                                       const OtherFile& /*other*/) {
  auto cameras = read_air_cameras(*file.document);
  if (!cameras) return cameras.error();
  StereoCalibration& c = cameras->rig;
  const auto& T = cameras->T;
  const RigidTransform to_body = T[1].inverse() * T[0];
  const RigidTransform from_body = T[1] * T[0].inverse();
  const auto cam1 = file.document->inner("cam1");
  if (cam1->has("T_type")) {
    const auto type = cam1->number("T_type");
    if (!type) return type.error();
    if (*type != 0.0 && *type != 1.0) {
      return Error{fmt::format("T_type {:g} is not known", *type), cam1->where("T_type"),
                   "give 0 (T takes the camera's points to the body) or 1 (the body's to the camera)"};
    }
    c.T_right_left = *type == 0.0 ? to_body : from_body;
    order_cameras(c);
  } else {
    const bool outwards = to_body.t.x() < from_body.t.x();
    c.T_right_left = outwards ? to_body : from_body;
    c.notes.push_back(
        fmt::format("T of the cameras has no T_type: taken for {}, by which the right camera lies on the "
                    "right",
                    outwards ? 0 : 1));
  }
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
