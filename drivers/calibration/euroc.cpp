// SPDX-License-Identifier: BSD-3-Clause
// EuRoC's sensor.yaml pair, Kalibr's camera chains and OKVIS' list: the same cameras in two files or in one.
#include <algorithm>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

// By which OpenVINS' settings name their chain.
constexpr const char* kOpenVinsChain = "relative_config_imucam";

// `terms`: those that the model has in front of fx.
Result<void> set_model(const std::string& model, std::vector<double> terms, const std::string& distortion,
                       const std::vector<double>& D, const Document& yaml, CameraCalibration& camera) {
  const std::string where = yaml.where("distortion_model");
  if (model.empty() || model == "pinhole") {
    if (distortion.empty() && !D.empty()) {
      return Error{"calibration lacks distortion_model", yaml.path(), "name it: radtan, equidistant or none"};
    }
    return set_distortion(distortion, D, where, camera);
  }
  if (model == "omni" && distortion != "none") {
    if (!distortion.empty() && distortion != "radtan") {
      return Error{"distortion model " + printable(distortion.substr(0, 32)) + " is not known for omni", where,
                   "calibrate as omni-radtan"};
    }
    terms.insert(terms.end(), D.begin(), D.end());
  }
  return set_distortion(model, terms, yaml.where("camera_model"), camera);
}

Result<CameraCalibration> read_sensor(const Document& yaml) {
  CameraCalibration camera;
  const std::string model = yaml.word("camera_model");
  const std::size_t in_front = model == "omni" ? 1 : model == "eucm" || model == "ds" ? 2 : 0;
  if (in_front == 0 && !model.empty() && model != "pinhole") {
    return Error{"camera model " + printable(model.substr(0, 32)) + " is not known", yaml.where("camera_model"),
                 "calibrate as pinhole, omni, eucm or ds"};
  }
  const Result<std::vector<double>> K = yaml.numbers("intrinsics", 4 + in_front);
  if (!K) return K.error();
  camera.fx_px = (*K)[in_front];
  camera.fy_px = (*K)[in_front + 1];
  camera.cx_px = (*K)[in_front + 2];
  camera.cy_px = (*K)[in_front + 3];
  const std::string key = yaml.first_of({"distortion_coefficients", "distortion_coeffs"});
  std::vector<double> D;
  if (!key.empty()) {
    const Result<std::vector<double>> read = yaml.numbers(key);
    if (!read) return read.error();
    D = *read;
  }
  const std::vector<double> terms(K->begin(), K->begin() + static_cast<std::ptrdiff_t>(in_front));
  if (auto ok = set_model(model, terms, yaml.word("distortion_model"), D, yaml, camera); !ok) return ok.error();
  if (auto ok = set_image_size(yaml, camera); !ok) return ok.error();
  return camera;
}

Result<CameraCalibration> read_okvis_camera(const Document& yaml) {
  CameraCalibration camera;
  const auto f = yaml.numbers("focal_length");
  if (!f) return f.error();
  const auto c = yaml.numbers("principal_point", 2);
  if (!c) return c.error();
  if (f->empty() || f->size() > 2) {
    return Error{"focal_length has no two numbers", yaml.where("focal_length"), "copy the calibration again"};
  }
  camera.fx_px = f->front();
  camera.fy_px = f->back();
  camera.cx_px = (*c)[0];
  camera.cy_px = (*c)[1];
  std::vector<double> D;
  if (yaml.has("distortion_coefficients")) {
    const auto read = yaml.numbers("distortion_coefficients");
    if (!read) return read.error();
    D = *read;
  }
  const std::string key = yaml.first_of({"distortion_type", "distortion_model"});
  if (auto ok = set_distortion(yaml.word(key), D, yaml.where("distortion_coefficients"), camera); !ok) {
    return ok.error();
  }
  if (auto ok = set_image_size(yaml, camera); !ok) return ok.error();
  return camera;
}

// Pose of the left camera in the right one, from either kind of pose against a third frame.
Result<RigidTransform> between(const Document& left, const Document& right, const std::string& key, bool camera_first) {
  const auto l = left.transform(key);
  if (!l) return l.error();
  const auto r = right.transform(key);
  if (!r) return r.error();
  return camera_first ? *r * l->inverse() : r->inverse() * *l;
}

Result<RigidTransform> read_chain(const Document& left, const Document& right) {
  if (right.has("T_cn_cnm1")) return right.transform("T_cn_cnm1");
  for (const char* key : {"T_cam_imu", "T_CI", "T_CB", "T_cam_body"}) {
    if (right.has(key)) return between(left, right, key, true);
  }
  for (const char* key : {"T_imu_cam", "T_IC", "T_BS", "T_BC", "T_SC", "T_body_cam"}) {
    if (right.has(key)) return between(left, right, key, false);
  }
  return Error{"calibration lacks the pose of cam1", right.path(),
               "it needs T_cn_cnm1 in cam1, or T_cam_imu or T_imu_cam in both"};
}

}  // namespace

bool is_euroc(const CalibrationText& file) {
  return file.has("intrinsics") && (file.has("T_BS") || file.has("sensor_type"));
}

bool is_kalibr(const CalibrationText& file) {
  if (!file.document) return false;
  if (file.has(kOpenVinsChain)) return true;
  const DocumentNode* cam0 = file.document->root().find("cam0");
  if (cam0 == nullptr) return false;
  const DocumentNode* intrinsics = cam0->find("intrinsics");
  if (intrinsics == nullptr) return cam0->entries.empty();
  // Others name cameras so too, with a matrix or with names for fx and so on, or with the pose elsewhere.
  const auto& items = intrinsics->items;
  if (!intrinsics->entries.empty() || items.size() == 9) return false;
  if (!items.empty() && items.front().kind == DocumentNode::Kind::list) return false;
  const DocumentNode* cam1 = file.document->root().find("cam1");
  if (cam1 == nullptr) return true;
  return std::any_of(cam1->entries.begin(), cam1->entries.end(), [](const DocumentEntry& entry) {
    return entry.name.starts_with("T_") || entry.name == "camera_model" || entry.name == "distortion_model";
  });
}

bool is_okvis(const CalibrationText& file) {
  if (!file.document) return false;
  const std::vector<Document> cameras = file.document->list("cameras");
  return !cameras.empty() && cameras.front().has("focal_length");
}

Result<StereoCalibration> read_euroc(const CalibrationText& file, const CalibrationRequest& request,
                                     const OtherFile& other) {
  const Result<Document> second = read_other(other, other_camera_paths(file.path));
  if (!second) return second.error();
  const bool swapped = is_right_of(file.path, second->path());
  const Document& left = swapped ? *second : *file.document;
  const Document& right = swapped ? *file.document : *second;
  StereoCalibration c;
  for (const Document* side : {&left, &right}) {
    const Result<CameraCalibration> camera = read_sensor(*side);
    if (!camera) return camera.error();
    (side == &left ? c.left : c.right) = *camera;
  }
  const auto T = between(left, right, "T_BS", false);
  if (!T) return T.error();
  c.T_right_left = *T;
  order_cameras(c);
  return finish_calibration(c, request);
}

Result<StereoCalibration> read_kalibr(const CalibrationText& file, const CalibrationRequest& request,
                                      const OtherFile& other) {
  Result<Document> chain = *file.document;
  if (file.has(kOpenVinsChain)) chain = read_other(other, {beside(file.path, file.document->word(kOpenVinsChain))});
  if (!chain) return chain.error();
  const Result<Document> left = chain->inner("cam0");
  if (!left) return left.error();
  const Result<Document> right = chain->inner("cam1");
  if (!right) return right.error();
  StereoCalibration c;
  for (const Result<Document>* side : {&left, &right}) {
    const Result<CameraCalibration> camera = read_sensor(**side);
    if (!camera) return camera.error();
    (side == &left ? c.left : c.right) = *camera;
  }
  const auto T = read_chain(*left, *right);
  if (!T) return T.error();
  c.T_right_left = *T;
  order_cameras(c);
  return finish_calibration(c, request);
}

Result<StereoCalibration> read_okvis(const CalibrationText& file, const CalibrationRequest& request,
                                     const OtherFile& /*other*/) {
  const std::vector<Document> cameras = file.document->list("cameras");
  if (cameras.size() < 2) {
    return Error{"calibration is of a single camera", file.path, "name the calibration of both cameras"};
  }
  StereoCalibration c;
  for (int side = 0; side < 2; ++side) {
    const auto camera = read_okvis_camera(cameras[static_cast<std::size_t>(side)]);
    if (!camera) return camera.error();
    (side == 0 ? c.left : c.right) = *camera;
  }
  const auto T = read_chain(cameras[0], cameras[1]);
  if (!T) return T.error();
  c.T_right_left = *T;
  order_cameras(c);
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
