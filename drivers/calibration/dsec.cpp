// SPDX-License-Identifier: BSD-3-Clause
// DSEC's cam_to_cam.yaml: four cameras in a row (events, frames, frames, events), their rectified ones, the poses.
#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

// Of both pairs the one of the images' size; of unknown ones the frames'.
struct DsecPair {
  int left;
  int right;
};
constexpr DsecPair kDsecFrames{1, 2};
constexpr DsecPair kDsecEvents{0, 3};

Result<CameraCalibration> read_dsec_camera(const Document& intrinsics, const std::string& name) {
  const auto yaml = intrinsics.inner(name);
  if (!yaml) return yaml.error();
  CameraCalibration camera;
  const auto K = yaml->numbers("camera_matrix", 4);
  if (!K) return K.error();
  const std::vector<double>& v = *K;
  if (auto ok = set_camera_matrix({v[0], 0, v[2], 0, v[1], v[3], 0, 0, 1}, yaml->where("camera_matrix"), camera); !ok) {
    return ok.error();
  }
  if (yaml->has("distortion_coeffs")) {
    const auto D = yaml->numbers("distortion_coeffs");
    if (!D) return D.error();
    if (auto ok = set_distortion(yaml->word("distortion_model"), *D, yaml->where("distortion_coeffs"), camera); !ok) {
      return ok.error();
    }
  }
  const auto size = yaml->image_size();
  if (!size) return size.error();
  if (!*size) return Error{"calibration lacks a camera's resolution", yaml->where("resolution"), "copy it again"};
  camera.width = (*size)->first;
  camera.height = (*size)->second;
  return camera;
}

Result<Eigen::Matrix3d> read_dsec_rotation(const Document& extrinsics, const std::string& key) {
  const auto R = extrinsics.numbers(key, 9);
  if (!R) return R.error();
  const Eigen::Matrix3d out = matrix3_from(*R);
  if (auto ok = check_rotation(out, extrinsics.where(key)); !ok) return ok.error();
  return out;
}

// From the pair's left camera to its right one, camera by camera.
Result<RigidTransform> read_dsec_pose(const Document& intrinsics, const Document& extrinsics, const DsecPair& pair) {
  RigidTransform out;
  for (int i = pair.left + 1; i <= pair.right; ++i) {
    const std::string step = fmt::format("T_{}{}", i, i - 1);
    const auto camera = intrinsics.inner(fmt::format("cam{}", i));
    if (!camera) return camera.error();
    const auto T = extrinsics.has(step) ? extrinsics.transform(step) : camera->transform("T_cn_cnm1");
    if (!T) return T.error();
    out = *T * out;
  }
  return out;
}

// What the file rectifies the pair to. Some leave the last camera's rotation out: it follows from the pose.
Result<PrescribedRectification> read_dsec_rectified(const Document& intrinsics, const Document& extrinsics,
                                                    const DsecPair& pair, const RigidTransform& T_right_left) {
  PrescribedRectification out;
  const auto R_left = read_dsec_rotation(extrinsics, fmt::format("R_rect{}", pair.left));
  if (!R_left) return R_left.error();
  out.R_left = *R_left;
  const std::string right = fmt::format("R_rect{}", pair.right);
  out.R_right = out.R_left * T_right_left.R.transpose();
  if (extrinsics.has(right)) {
    const auto R_right = read_dsec_rotation(extrinsics, right);
    if (!R_right) return R_right.error();
    out.R_right = *R_right;
  }
  const auto l = read_dsec_camera(intrinsics, fmt::format("camRect{}", pair.left));
  if (!l) return l.error();
  const auto r = read_dsec_camera(intrinsics, fmt::format("camRect{}", pair.right));
  if (!r) return r.error();
  const double shift = -r->fx_px * T_right_left.t.norm();
  const auto model = model_from_projections({l->fx_px, 0, l->cx_px, 0, 0, l->fy_px, l->cy_px, 0, 0, 0, 1, 0},
                                            {r->fx_px, 0, r->cx_px, shift, 0, r->fy_px, r->cy_px, 0, 0, 0, 1, 0},
                                            intrinsics.path() + " (camRect)");
  if (!model) return model.error();
  out.model = *model;
  out.model.width = l->width;
  out.model.height = l->height;
  return out;
}

}  // namespace

bool is_dsec(const CalibrationText& file) {
  if (!file.document || !file.has("extrinsics")) return false;
  const DocumentNode* intrinsics = file.document->root().find("intrinsics");
  return intrinsics != nullptr && intrinsics->find("cam1") != nullptr && intrinsics->find("camRect1") != nullptr;
}

Result<StereoCalibration> read_dsec(const CalibrationText& file, const CalibrationRequest& request,
                                    const OtherFile& /*other*/) {
  const auto intrinsics = file.document->inner("intrinsics");
  if (!intrinsics) return intrinsics.error();
  const auto extrinsics = file.document->inner("extrinsics");
  if (!extrinsics) return extrinsics.error();
  DsecPair pair = kDsecFrames;
  const auto events = read_dsec_camera(*intrinsics, "cam0");
  if (events && request.width > 0 && events->width == request.width && events->height == request.height) {
    pair = kDsecEvents;
  }
  StereoCalibration c;
  const auto left = read_dsec_camera(*intrinsics, fmt::format("cam{}", pair.left));
  if (!left) return left.error();
  const auto right = read_dsec_camera(*intrinsics, fmt::format("cam{}", pair.right));
  if (!right) return right.error();
  c.left = *left;
  c.right = *right;
  const auto T = read_dsec_pose(*intrinsics, *extrinsics, pair);
  if (!T) return T.error();
  c.T_right_left = *T;
  auto rectified = read_dsec_rectified(*intrinsics, *extrinsics, pair, *T);
  if (!rectified) return rectified.error();
  c.prescribed = *rectified;
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
