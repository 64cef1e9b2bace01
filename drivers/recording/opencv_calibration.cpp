// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/yaml_calibration.h"

namespace cliquevo::drivers {

namespace {

// The usual names of each matrix, the left eye's and the right eye's.
std::string camera_matrix(const YamlReader& yaml, bool left) {
  return left ? yaml.first_of({"K1", "M1", "cameraMatrix1", "camera_matrix_1", "camera_matrix_left", "K_left",
                               "left_camera_matrix", "LEFT.K", "K_l"})
              : yaml.first_of({"K2", "M2", "cameraMatrix2", "camera_matrix_2", "camera_matrix_right", "K_right",
                               "right_camera_matrix", "RIGHT.K", "K_r"});
}

std::string distortion(const YamlReader& yaml, bool left) {
  return left ? yaml.first_of({"D1", "distCoeffs1", "dist_coeffs_1", "dist_coeffs_left", "D_left",
                               "left_distortion_coefficients", "LEFT.D", "D_l"})
              : yaml.first_of({"D2", "distCoeffs2", "dist_coeffs_2", "dist_coeffs_right", "D_right",
                               "right_distortion_coefficients", "RIGHT.D", "D_r"});
}

Result<CameraCalibration> read_camera(const YamlReader& yaml, bool left) {
  CameraCalibration camera;
  std::string key = camera_matrix(yaml, left);
  const Result<std::vector<double>> K = yaml.numbers(key.empty() ? (left ? "K1" : "K2") : key, 9);
  if (!K) return K.error();
  if (const auto ok = set_camera_matrix(*K, yaml.where(key), camera); !ok) return ok.error();
  key = distortion(yaml, left);
  if (key.empty()) key = left ? "D1" : "D2";
  const Result<std::vector<double>> D = yaml.numbers(key);
  if (!D) return D.error();
  // Four numbers are plumb bob unless the file calls itself a fisheye.
  const std::string model = yaml.first_of({"distortion_model", "camera_model", "model"});
  std::string name = model.empty() ? std::string{} : yaml.word(model);
  if (name == "pinhole") name.clear();
  if (const auto ok = set_distortion(name, *D, yaml.where(key), camera); !ok) return ok.error();
  return camera;
}

}  // namespace

bool has_opencv_intrinsics(const YamlReader& yaml) { return !camera_matrix(yaml, true).empty(); }
bool has_opencv_extrinsics(const YamlReader& yaml) { return yaml.has("R") && yaml.has("T"); }

Result<StereoCalibration> parse_opencv(const YamlReader& intrinsics, const YamlReader& extrinsics,
                                       const CalibrationRequest& request) {
  StereoCalibration c;
  const Result<CameraCalibration> left = read_camera(intrinsics, true);
  if (!left) return left.error();
  const Result<CameraCalibration> right = read_camera(intrinsics, false);
  if (!right) return right.error();
  c.left = *left;
  c.right = *right;
  for (const YamlReader* yaml : {&extrinsics, &intrinsics}) {
    const auto size = yaml->image_size();
    if (!size) return size.error();
    if (!*size) continue;
    c.left.width = c.right.width = (*size)->first;
    c.left.height = c.right.height = (*size)->second;
  }
  Result<std::vector<double>> R = extrinsics.numbers("R");
  if (!R) return R.error();
  if (R->size() == 3) {  // as a rotation vector
    const Eigen::Matrix3d rotation = so3_exp({R.value()[0], R.value()[1], R.value()[2]});
    c.T_right_left.R = rotation;
  } else if (R->size() == 9) {
    c.T_right_left.R = matrix3_from(*R);
  } else {
    return calibration_error("R is no 3x3 matrix", extrinsics.where("R"));
  }
  if (const auto ok = check_rotation(c.T_right_left.R, extrinsics.where("R")); !ok) return ok.error();
  const Result<std::vector<double>> T = extrinsics.numbers("T", 3);
  if (!T) return T.error();
  c.T_right_left.t = {T.value()[0], T.value()[1], T.value()[2]};

  if (extrinsics.has("R1") && extrinsics.has("R2") && extrinsics.has("P1") && extrinsics.has("P2")) {
    const Result<std::vector<double>> R1 = extrinsics.numbers("R1", 9);
    if (!R1) return R1.error();
    const Result<std::vector<double>> R2 = extrinsics.numbers("R2", 9);
    if (!R2) return R2.error();
    const Result<std::vector<double>> P1 = extrinsics.numbers("P1", 12);
    if (!P1) return P1.error();
    const Result<std::vector<double>> P2 = extrinsics.numbers("P2", 12);
    if (!P2) return P2.error();
    const Result<StereoModel> model = model_from_projections(*P1, *P2, extrinsics.where("P2"));
    if (!model) return model.error();
    c.prescribed = PrescribedRectification{matrix3_from(*R1), matrix3_from(*R2), *model};
  }
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
