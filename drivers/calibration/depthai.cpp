// SPDX-License-Identifier: BSD-3-Clause
// Luxonis' DepthAI calibration in JSON: cameras by socket, each with its pose against another one; lengths in cm.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

struct Camera {
  CameraCalibration camera;
  RigidTransform T_other_this;  // m
  int other = -1;
};

Result<RigidTransform> read_depthai_pose(const Document& extrinsics) {
  RigidTransform T;
  const auto R = extrinsics.numbers("rotationMatrix");
  if (!R) return R.error();
  if (R->empty()) return T;  // the camera that others refer to
  if (R->size() != 9) {
    return Error{"rotationMatrix is no 3x3 matrix", extrinsics.where("rotationMatrix"), "copy the calibration again"};
  }
  T.R = matrix3_from(*R);
  for (const char* key : {"translation", "specTranslation"}) {  // as measured, else as built
    if (!extrinsics.has(key)) continue;
    const auto t = extrinsics.inner(key);
    if (!t) return t.error();
    int axis = 0;
    for (const char* name : {"x", "y", "z"}) {
      const auto value = t->number(name);
      if (!value) return value.error();
      T.t[axis++] = 0.01 * *value;
    }
    if (T.t.norm() > 0.0) break;
  }
  return T;
}

Result<Camera> read_depthai_camera(const Document& data) {
  Camera out;
  const auto K = data.numbers("intrinsicMatrix", 9);
  if (!K) return K.error();
  if (auto ok = set_camera_matrix(*K, data.where("intrinsicMatrix"), out.camera); !ok) return ok.error();
  const auto D = data.numbers("distortionCoeff");
  if (!D) return D.error();
  const std::string type = data.word("cameraType");
  if (type != "0" && type != "1" && !type.empty()) {
    return Error{"camera type " + printable(type.substr(0, 16)) + " is not known", data.where("cameraType"),
                 "calibrate as perspective or fisheye"};
  }
  if (auto ok = set_distortion(type == "1" ? "fisheye" : "", *D, data.where("distortionCoeff"), out.camera); !ok) {
    return ok.error();
  }
  if (auto ok = set_image_size(data, out.camera); !ok) return ok.error();
  const auto extrinsics = data.inner("extrinsics");
  if (!extrinsics) return extrinsics.error();
  const auto pose = read_depthai_pose(*extrinsics);
  if (!pose) return pose.error();
  out.T_other_this = *pose;
  if (const auto other = extrinsics->number("toCameraSocket")) {
    out.other = *other >= 0.0 && *other < 100.0 ? static_cast<int>(*other) : -1;
  }
  return out;
}

using Cameras = std::map<int, Camera>;

Result<Cameras> read_cameras(const Document& file) {
  Cameras out;
  const DocumentNode* list = file.root().find("cameraData");
  for (const DocumentNode& item : list->items) {  // [socket, {...}]
    if (item.items.size() != 2) return calibration_error("cameraData holds no pairs of socket and camera", file.path());
    const auto socket = numbers_of(item.items[0], file.where("cameraData"));
    if (!socket) return socket.error();
    if (socket->size() != 1 || !((*socket)[0] >= 0.0 && (*socket)[0] < 100.0)) {
      return calibration_error("socket of a camera is absurd", file.where("cameraData"));
    }
    const auto camera = read_depthai_camera(Document::of(item.items[1], file.path()));
    if (camera) out[static_cast<int>((*socket)[0])] = *camera;  // an empty socket has no numbers
  }
  return out;
}

// From the first camera to the second, along the poses that the file has.
std::optional<RigidTransform> between(const Cameras& cameras, int from, int to) {
  std::map<int, RigidTransform> reached{{from, RigidTransform{}}};  // T_this_from
  for (std::size_t round = 0; round <= cameras.size(); ++round) {
    for (const auto& [socket, camera] : cameras) {
      if (cameras.count(camera.other) == 0) continue;
      if (reached.count(socket) != 0 && reached.count(camera.other) == 0) {
        reached[camera.other] = camera.T_other_this * reached[socket];
      } else if (reached.count(socket) == 0 && reached.count(camera.other) != 0) {
        reached[socket] = camera.T_other_this.inverse() * reached[camera.other];
      }
    }
  }
  const auto found = reached.find(to);
  return found == reached.end() ? std::nullopt : std::optional(found->second);
}

// The left and right camera by the file, else the sockets of the boards' stereo cameras.
std::pair<int, int> sockets(const Document& file) {
  if (const auto data = file.inner("stereoRectificationData")) {
    const auto left = data->number("leftCameraSocket");
    const auto right = data->number("rightCameraSocket");
    if (left && right && *left >= 0.0 && *right >= 0.0 && *left != *right && *left < 100.0 && *right < 100.0) {
      return {static_cast<int>(*left), static_cast<int>(*right)};
    }
  }
  return {1, 2};
}

// The devices cut smaller aspects out of the middle.
void crop(CameraCalibration& c, const CalibrationRequest& request) {
  if (request.width <= 0 || c.width <= 0) return;
  const double by =
      std::max(static_cast<double>(request.width) / c.width, static_cast<double>(request.height) / c.height);
  const double width = request.width / by;
  const double height = request.height / by;
  if (std::abs(width - c.width) < 1.0 && std::abs(height - c.height) < 1.0) return;
  c.cx_px -= 0.5 * (c.width - width);
  c.cy_px -= 0.5 * (c.height - height);
  c.width = static_cast<int>(std::lround(width));
  c.height = static_cast<int>(std::lround(height));
}

}  // namespace

bool is_depthai(const CalibrationText& file) {
  if (!file.document) return false;
  const DocumentNode* data = file.document->root().find("cameraData");
  return data != nullptr && data->kind == DocumentNode::Kind::list;
}

Result<StereoCalibration> read_depthai(const CalibrationText& file, const CalibrationRequest& request,
                                       const OtherFile& /*other*/) {
  const auto cameras = read_cameras(*file.document);
  if (!cameras) return cameras.error();
  auto [left, right] = sockets(*file.document);
  if (cameras->count(left) == 0 || cameras->count(right) == 0) {
    return Error{"calibration lacks a stereo camera", fmt::format("{} (sockets {} and {})", file.path, left, right),
                 "name the calibration of the device that took the images"};
  }
  std::optional<RigidTransform> T = between(*cameras, left, right);
  if (!T) return calibration_error("extrinsics do not link the stereo cameras", file.path);
  if (T->t.x() > 0.0) {
    std::swap(left, right);
    T = T->inverse();
  }
  StereoCalibration c;
  c.left = cameras->at(left).camera;
  c.right = cameras->at(right).camera;
  c.T_right_left = *T;
  const int height = c.left.height;
  crop(c.left, request);
  crop(c.right, request);
  if (c.left.height != height) {
    c.notes.push_back(
        fmt::format("images of {}x{} taken for the middle of those calibrated", request.width, request.height));
  }
  return finish_calibration(c, request, 0.01);
}

}  // namespace cliquevo::drivers
