// SPDX-License-Identifier: BSD-3-Clause
// EuRoC's sensor.yaml pair and Kalibr's camchain.yaml: the same cameras in two files or in one.
#include "drivers/recording/yaml_calibration.h"

namespace cliquevo::drivers {

namespace {

Result<CameraCalibration> read_camera(const YamlReader& yaml) {
  CameraCalibration camera;
  const std::string model = yaml.word("camera_model");
  if (!model.empty() && model != "pinhole") {
    return Error{"camera model is not known", yaml.where("camera_model"), "calibrate as pinhole"};
  }
  const Result<std::vector<double>> K = yaml.numbers("intrinsics", 4);
  if (!K) return K.error();
  camera.fx_px = K.value()[0];
  camera.fy_px = K.value()[1];
  camera.cx_px = K.value()[2];
  camera.cy_px = K.value()[3];
  const std::string key = yaml.first_of({"distortion_coefficients", "distortion_coeffs"});
  std::vector<double> D;
  if (!key.empty()) {
    const Result<std::vector<double>> read = yaml.numbers(key);
    if (!read) return read.error();
    D = *read;
  }
  const std::string distortion = yaml.word("distortion_model");
  if (distortion.empty() && !D.empty()) {
    return Error{"calibration lacks distortion_model", yaml.path(), "name it: radtan, equidistant or none"};
  }
  if (const auto ok = set_distortion(distortion, D, yaml.where("distortion_model"), camera); !ok) return ok.error();
  const auto size = yaml.image_size();
  if (!size) return size.error();
  if (*size) {
    camera.width = (*size)->first;
    camera.height = (*size)->second;
  }
  return camera;
}

}  // namespace

bool is_euroc(const YamlReader& yaml) {
  return yaml.has("intrinsics") && (yaml.has("T_BS") || yaml.has("sensor_type"));
}
bool is_kalibr(const YamlReader& yaml) { return yaml.has("cam0"); }

Result<StereoCalibration> parse_euroc(const YamlReader& left, const YamlReader& right,
                                      const CalibrationRequest& request) {
  StereoCalibration c;
  RigidTransform T_body_eye[2];
  int i = 0;
  for (const YamlReader* eye : {&left, &right}) {
    const Result<CameraCalibration> camera = read_camera(*eye);
    if (!camera) return camera.error();
    (i == 0 ? c.left : c.right) = *camera;
    const Result<RigidTransform> T = eye->transform("T_BS");
    if (!T) return T.error();
    T_body_eye[i++] = *T;
  }
  c.T_right_left = T_body_eye[1].inverse() * T_body_eye[0];
  return finish_calibration(c, request);
}

Result<StereoCalibration> parse_kalibr(const YamlReader& chain, const CalibrationRequest& request) {
  const Result<YamlReader> left = chain.inner("cam0");
  if (!left) return left.error();
  const Result<YamlReader> right = chain.inner("cam1");
  if (!right) return right.error();
  StereoCalibration c;
  const Result<CameraCalibration> left_camera = read_camera(*left);
  if (!left_camera) return left_camera.error();
  c.left = *left_camera;
  const Result<CameraCalibration> right_camera = read_camera(*right);
  if (!right_camera) return right_camera.error();
  c.right = *right_camera;
  if (right->has("T_cn_cnm1") || !right->has("T_cam_imu")) {
    const Result<RigidTransform> T = right->transform("T_cn_cnm1");
    if (!T) return T.error();
    c.T_right_left = *T;
  } else {  // a camera-IMU chain
    const Result<RigidTransform> T_left_imu = left->transform("T_cam_imu");
    if (!T_left_imu) return T_left_imu.error();
    const Result<RigidTransform> T_right_imu = right->transform("T_cam_imu");
    if (!T_right_imu) return T_right_imu.error();
    c.T_right_left = *T_right_imu * T_left_imu->inverse();
  }
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
