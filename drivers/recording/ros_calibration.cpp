// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "drivers/recording/yaml_calibration.h"

namespace cliquevo::drivers {

namespace {

struct CameraInfo {
  CameraCalibration camera;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // raw -> rectified
  std::vector<double> P;                            // 12 numbers
};

Result<CameraInfo> read_info(const YamlReader& yaml) {
  CameraInfo info;
  const auto required = [&](std::initializer_list<const char*> names, const char* name) {
    const std::string key = yaml.first_of(names);
    return key.empty() ? std::string(name) : key;
  };
  const std::string k = required({"camera_matrix", "K", "k"}, "camera_matrix");
  const Result<std::vector<double>> K = yaml.numbers(k, 9);
  if (!K) return K.error();
  if (const auto ok = set_camera_matrix(*K, yaml.where(k), info.camera); !ok) return ok.error();
  const std::string d = required({"distortion_coefficients", "D", "d"}, "distortion_coefficients");
  const Result<std::vector<double>> D = yaml.numbers(d);
  if (!D) return D.error();
  if (const auto ok = set_distortion(yaml.word("distortion_model"), *D, yaml.where(d), info.camera); !ok) {
    return ok.error();
  }
  if (const std::string r = yaml.first_of({"rectification_matrix", "R", "r"}); !r.empty()) {
    const Result<std::vector<double>> R = yaml.numbers(r, 9);
    if (!R) return R.error();
    info.R = matrix3_from(*R);
    if (const auto ok = check_rotation(info.R, yaml.where(r)); !ok) return ok.error();
  }
  const Result<std::vector<double>> P =
      yaml.numbers(required({"projection_matrix", "P", "p"}, "projection_matrix"), 12);
  if (!P) return P.error();
  info.P = *P;
  const auto size = yaml.image_size();
  if (!size) return size.error();
  if (*size) {
    info.camera.width = (*size)->first;
    info.camera.height = (*size)->second;
  }
  return info;
}

}  // namespace

bool is_ros(const YamlReader& yaml) {
  return !yaml.first_of({"camera_matrix", "K", "k"}).empty() && !yaml.first_of({"projection_matrix", "P", "p"}).empty();
}

Result<StereoCalibration> parse_ros(const YamlReader& left, const YamlReader& right,
                                    const CalibrationRequest& request) {
  const Result<CameraInfo> l = read_info(left);
  if (!l) return l.error();
  Result<CameraInfo> r = read_info(right);
  if (!r) return r.error();
  // Some drivers leave the baseline out of P and give T (left -> right, m) instead.
  if (r->P[3] == 0.0 && l->P[3] == 0.0) {
    if (!right.has("T")) return calibration_error("baseline is zero (P of the right eye has no fx * Tx)", right.path());
    const Result<std::vector<double>> T = right.numbers("T", 3);
    if (!T) return T.error();
    const double length = std::hypot(T.value()[0], T.value()[1], T.value()[2]);
    r->P[3] = (T.value()[0] < 0.0 ? -1.0 : 1.0) * r->P[0] * length;
  }
  const Result<StereoModel> model = model_from_projections(l->P, r->P, right.path() + " (projection matrix)");
  if (!model) return model.error();
  StereoCalibration c;
  c.left = l->camera;
  c.right = r->camera;
  // In the rectified frames the eyes differ by the baseline alone.
  c.T_right_left.R = r->R.transpose() * l->R;
  c.T_right_left.t = r->R.transpose() * Eigen::Vector3d(-model->baseline_m, 0.0, 0.0);
  c.prescribed = PrescribedRectification{l->R, r->R, *model};
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
