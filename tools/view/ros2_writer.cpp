// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/ros2_writer.h"

#include <charconv>

#include <Eigen/Geometry>

#include "daemon/ros2/messages.h"

namespace cliquevo::view {

namespace {
constexpr TimestampNs kPathEvery_ns = 500'000'000;
}  // namespace

Ros2Writer::Ros2Writer(Ros2Topics& topics, const RigidTransform& T_body_camera)
    : topics_(topics), T_body_camera_(T_body_camera) {
  ros2::put_transform(0, ros2::kBodyFrame, ros2::kLeftFrame, T_body_camera_, cdr_);
  put(Topic::tf_static, 0);
}

void Ros2Writer::mount(const RigidTransform& T_body_camera) {
  if (T_body_camera.t == T_body_camera_.t && T_body_camera.R == T_body_camera_.R) return;
  T_body_camera_ = T_body_camera;
  ros2::put_transform(last_ns_, ros2::kBodyFrame, ros2::kLeftFrame, T_body_camera_, cdr_);
  put(Topic::tf_static, last_ns_);
}

void Ros2Writer::add(const odometry_t& m) {
  const TimestampNs stamp_ns = m.utime * 1000;
  if (stamp_ns < last_ns_) path_ = {};  // the source began anew
  ros2::put_odometry(m, cdr_);
  put(Topic::odom, stamp_ns);
  const RigidTransform T = ros2::pose_of(m);
  const Eigen::Quaterniond q(T.R);
  ros2::put_pose(stamp_ns, T.t, {q.w(), q.x(), q.y(), q.z()}, cdr_);
  put(Topic::pose, stamp_ns);
  ros2::put_transform(stamp_ns, ros2::kOdomFrame, ros2::kBodyFrame, T, cdr_);
  put(Topic::tf, stamp_ns);
  ros2::put_diagnostics(m, cdr_);
  put(Topic::diagnostics, stamp_ns);
  path_.add(T.t);
  last_ns_ = stamp_ns;
  if (stamp_ns - path_ns_ < kPathEvery_ns && stamp_ns >= path_ns_) return;
  path_ns_ = stamp_ns;
  ros2::put_points(stamp_ns, ros2::kOdomFrame, path_.points(), cdr_);
  put(Topic::path, stamp_ns);
}

void Ros2Writer::add(const points_t& m) {
  if (!wants_points()) return;
  ros2::put_points(m, cdr_);
  put(Topic::points, m.utime * 1000);
}

void Ros2Writer::add_left(TimestampNs stamp_ns, ImageView<const std::uint8_t> left,
                          const std::optional<StereoModel>& model) {
  if (model && topics_.wanted(Topic::camera_info)) {
    StereoCalibration calibration;
    calibration.rectified = true;
    calibration.prescribed = PrescribedRectification{};
    calibration.prescribed->model = *model;
    ros2::put_camera_info(stamp_ns, calibration, true, cdr_);
    put(Topic::camera_info, stamp_ns);
  }
  if (!topics_.wanted(Topic::left)) return;
  ros2::put_image(stamp_ns, ros2::kLeftFrame, left, cdr_);
  put(Topic::left, stamp_ns);
}

void Ros2Writer::add_disparity(TimestampNs stamp_ns, ImageView<const std::int16_t> disparity) {
  if (!topics_.wanted(Topic::disparity)) return;
  ros2::put_disparity(stamp_ns, ros2::kLeftFrame, disparity, cdr_);
  put(Topic::disparity, stamp_ns);
}

std::optional<StereoModel> camera_of(const image_t& image) {
  StereoModel out;
  out.width = image.width;
  out.height = image.height;
  const std::pair<std::string_view, double*> fields[] = {{"fx_px", &out.fx_px},           {"fy_px", &out.fy_px},
                                                         {"cx_px", &out.cx_px},           {"cy_px", &out.cy_px},
                                                         {"baseline_m", &out.baseline_m}, {"doffs_px", &out.doffs_px}};
  for (const image_metadata_t& entry : image.metadata) {
    for (const auto& [name, value] : fields) {
      if (entry.key != name) continue;
      const char* begin = reinterpret_cast<const char*>(entry.value.data());
      std::from_chars(begin, begin + entry.value.size(), *value);
    }
  }
  if (!out.check()) return std::nullopt;
  return out;
}

}  // namespace cliquevo::view
