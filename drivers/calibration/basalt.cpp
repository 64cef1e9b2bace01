// SPDX-License-Identifier: BSD-3-Clause
// Basalt's calibration.json: T_imu_cam as position and quaternion, intrinsics by camera_type, resolution.
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

Result<CameraCalibration> read_basalt_camera(const Document& entry) {
  CameraCalibration camera;
  const auto values = entry.inner("intrinsics");
  if (!values) return values.error();
  for (const auto& [key, target] :
       {std::pair{"fx", &camera.fx_px}, {"fy", &camera.fy_px}, {"cx", &camera.cx_px}, {"cy", &camera.cy_px}}) {
    const auto value = values->number(key);
    if (!value) return value.error();
    *target = *value;
  }
  struct Model {
    const char* name;
    std::vector<const char*> terms;
    const char* distortion;
  };
  const std::vector<Model> models{{"pinhole", {}, "none"},
                                  {"pinhole-radtan8", {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}, "rational"},
                                  {"pinhole-radtan4", {"k1", "k2", "p1", "p2"}, "radtan"},
                                  {"pinhole-radtan5", {"k1", "k2", "p1", "p2", "k3"}, "radtan"},
                                  {"kb4", {"k1", "k2", "k3", "k4"}, "kb4"},
                                  {"ds", {"xi", "alpha"}, "ds"},
                                  {"eucm", {"alpha", "beta"}, "eucm"},
                                  {"ucm", {"alpha"}, "ucm"}};
  const std::string type = entry.word("camera_type");
  for (const Model& model : models) {
    if (type != model.name) continue;
    std::vector<double> D;
    for (const char* term : model.terms) {
      const auto value = values->number(term);
      if (!value) return value.error();
      D.push_back(*value);
    }
    std::string distortion = model.distortion;
    if (distortion == "ucm") {  // eucm with a sphere
      distortion = "eucm";
      D.push_back(1.0);
    }
    if (auto ok = set_distortion(distortion, D, entry.where("camera_type"), camera); !ok) return ok.error();
    return camera;
  }
  return Error{"camera type " + printable(type.substr(0, 32)) + " is not known", entry.where("camera_type"),
               "calibrate as pinhole, pinhole-radtan8, kb4, ds, eucm or ucm"};
}

Result<RigidTransform> read_basalt_pose(const Document& entry) {
  double v[7];
  int i = 0;
  for (const char* key : {"px", "py", "pz", "qx", "qy", "qz", "qw"}) {
    const auto value = entry.number(key);
    if (!value) return value.error();
    v[i++] = *value;
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) < 0.01)) return calibration_error("quaternion is not of length 1", entry.where("qw"));
  return RigidTransform{q.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
}

}  // namespace

bool is_basalt(const CalibrationText& file) {
  if (!file.document) return false;
  const DocumentNode& root = file.document->root();
  const DocumentNode* value = root.find("value0");
  const DocumentNode& inner = value != nullptr ? *value : root;
  return inner.find("T_imu_cam") != nullptr && inner.find("intrinsics") != nullptr;
}

Result<StereoCalibration> read_basalt(const CalibrationText& file, const CalibrationRequest& request,
                                      const OtherFile& /*other*/) {
  const auto value = file.has("value0") ? file.document->inner("value0") : Result<Document>(*file.document);
  if (!value) return value.error();
  const std::vector<Document> cameras = value->list("intrinsics");
  const std::vector<Document> poses = value->list("T_imu_cam");
  if (cameras.size() < 2 || poses.size() < 2) {
    return Error{"calibration is of a single camera", file.path, "name the calibration of both cameras"};
  }
  StereoCalibration c;
  RigidTransform T_imu_camera[2];
  for (std::size_t side = 0; side < 2; ++side) {
    const auto camera = read_basalt_camera(cameras[side]);
    if (!camera) return camera.error();
    const auto pose = read_basalt_pose(poses[side]);
    if (!pose) return pose.error();
    (side == 0 ? c.left : c.right) = *camera;
    T_imu_camera[side] = *pose;
  }
  if (value->has("resolution")) {
    const auto sizes = value->numbers("resolution");
    if (!sizes) return sizes.error();
    if (sizes->size() < 4 || sizes->size() % 2 != 0) {
      return calibration_error("resolution is not of both cameras", value->where("resolution"));
    }
    for (std::size_t side = 0; side < 2; ++side) {
      const auto size = size_from((*sizes)[2 * side], (*sizes)[2 * side + 1], value->where("resolution"));
      if (!size) return size.error();
      CameraCalibration& camera = side == 0 ? c.left : c.right;
      camera.width = size->first;
      camera.height = size->second;
    }
  }
  c.T_right_left = T_imu_camera[1].inverse() * T_imu_camera[0];
  order_cameras(c);
  return finish_calibration(c, request);
}

}  // namespace cliquevo::drivers
