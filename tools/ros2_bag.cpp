// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ros2_bag.h"

#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "daemon/ros2/messages.h"
#include "daemon/ros2/thinned_path.h"
#include "drivers/bags/mcap_writer.h"
#include "drivers/bags/ros2_definitions.h"
#include "drivers/images/png_writer.h"
#include "stereo/rectification.h"

namespace cliquevo::tools {

namespace {

constexpr std::int64_t kPathEvery_ns = 1'000'000'000;

}  // namespace

struct Ros2Bag::Impl {
  Impl(drivers::McapWriter out, StereoCalibration of_source, const RigidTransform& camera, BagImages form)
      : writer(std::move(out)), calibration(std::move(of_source)), T_body_camera(camera), images(form) {
    if (calibration.prescribed) return;
    if (auto chosen = stereo::choose_rectification(calibration)) calibration.prescribed = *chosen;
  }

  // What is in `cdr`, on a topic that begins with its first message.
  Result<void> write(const std::string& topic, const std::string& package, const std::string& type,
                     TimestampNs stamp_ns) {
    auto channel = channels.find(topic);
    if (channel == channels.end()) {
      const std::uint16_t number = writer.add_channel(
          topic, package + "/msg/" + type, drivers::ros2_definition(package + "/" + type), topic == "/tf_static");
      channel = channels.emplace(topic, number).first;
    }
    return writer.write(channel->second, stamp_ns, cdr.bytes());
  }

  Result<void> write_image(const std::string& topic, const drivers::StereoPair& pair, bool left) {
    const std::string_view frame = left ? ros2::kLeftFrame : ros2::kRightFrame;
    const ImageView<const std::uint8_t> image = left ? pair.left.cview() : pair.right.cview();
    if (images == BagImages::plain) {
      ros2::put_image(pair.stamp_ns, frame, image, cdr);
      return write(topic, "sensor_msgs", "Image", pair.stamp_ns);
    }
    const auto file = drivers::encode_png(image);
    if (!file) return file.error();
    ros2::put_png(pair.stamp_ns, frame, *file, cdr);
    return write(topic + "/compressed", "sensor_msgs", "CompressedImage", pair.stamp_ns);
  }

  Result<void> write_camera(const drivers::StereoPair& pair, bool left) {
    const std::string camera = left ? "/stereo/left" : "/stereo/right";
    const std::string topic = camera + (calibration.rectified ? "/image_rect" : "/image_raw");
    if (auto ok = write_image(topic, pair, left); !ok) return ok;
    ros2::put_camera_info(pair.stamp_ns, calibration, left, cdr);
    return write(camera + "/camera_info", "sensor_msgs", "CameraInfo", pair.stamp_ns);
  }

  Result<void> write_pose(TimestampNs stamp_ns, const RigidTransform& T) {
    const Eigen::Quaterniond q(T.R);
    ros2::put_pose(stamp_ns, T.t, {q.w(), q.x(), q.y(), q.z()}, cdr);
    if (auto ok = write("/pose", "geometry_msgs", "PoseStamped", stamp_ns); !ok) return ok;
    ros2::put_transform(stamp_ns, ros2::kOdomFrame, ros2::kBodyFrame, T, cdr);
    if (auto ok = write("/tf", "tf2_msgs", "TFMessage", stamp_ns); !ok) return ok;
    if (last_ns == 0) {
      ros2::put_transform(stamp_ns, ros2::kBodyFrame, ros2::kLeftFrame, T_body_camera, cdr);
      if (auto ok = write("/tf_static", "tf2_msgs", "TFMessage", stamp_ns); !ok) return ok;
    }
    path.add(T.t);
    last_ns = stamp_ns;
    return stamp_ns - path_ns < kPathEvery_ns && path_ns <= stamp_ns ? Result<void>() : write_path();
  }

  Result<void> write_path() {
    path_ns = last_ns;
    ros2::put_points(last_ns, ros2::kOdomFrame, path.points(), cdr);
    return write("/path", "sensor_msgs", "PointCloud2", last_ns);
  }

  drivers::McapWriter writer;
  StereoCalibration calibration;
  RigidTransform T_body_camera;
  BagImages images;
  std::map<std::string, std::uint16_t> channels;
  drivers::CdrWriter cdr;
  ros2::ThinnedPath path;
  TimestampNs path_ns = 0;  // of the path that was written last
  TimestampNs last_ns = 0;  // of the pose that was written last
};

Ros2Bag::Ros2Bag(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Ros2Bag::Ros2Bag(Ros2Bag&&) noexcept = default;
Ros2Bag& Ros2Bag::operator=(Ros2Bag&&) noexcept = default;
Ros2Bag::~Ros2Bag() = default;
std::int64_t Ros2Bag::bytes() const { return impl_->writer.bytes(); }

Result<Ros2Bag> Ros2Bag::create(const std::string& path, const drivers::SourceInfo& info,
                                const RigidTransform& T_body_camera, BagImages images) {
  auto writer = drivers::McapWriter::create(path);
  if (!writer) return writer.error();
  return Ros2Bag(std::make_unique<Impl>(std::move(*writer), info.calibration, T_body_camera, images));
}

Result<void> Ros2Bag::add(const drivers::StereoPair& pair) {
  if (auto ok = impl_->write_camera(pair, true); !ok) return ok;
  return impl_->write_camera(pair, false);
}

Result<void> Ros2Bag::add(const odometry_t& m) {
  const TimestampNs stamp_ns = m.utime * 1000;
  ros2::put_odometry(m, impl_->cdr);
  if (auto ok = impl_->write("/odom", "nav_msgs", "Odometry", stamp_ns); !ok) return ok;
  ros2::put_diagnostics(m, impl_->cdr);
  if (auto ok = impl_->write("/diagnostics", "diagnostic_msgs", "DiagnosticArray", stamp_ns); !ok) return ok;
  return impl_->write_pose(stamp_ns, ros2::pose_of(m));
}

Result<void> Ros2Bag::add(const pose_t& m) {
  RigidTransform T;
  const auto& q = m.orientation;
  T.R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  T.t = {m.pos[0], m.pos[1], m.pos[2]};
  return impl_->write_pose(m.utime * 1000, T);
}

Result<void> Ros2Bag::add(const points_t& m) {
  ros2::put_points(m, impl_->cdr);
  return impl_->write("/stereo/points2", "sensor_msgs", "PointCloud2", m.utime * 1000);
}

Result<void> Ros2Bag::finish() {
  if (impl_->last_ns != impl_->path_ns) {
    if (auto ok = impl_->write_path(); !ok) return ok;
  }
  return impl_->writer.close();
}

}  // namespace cliquevo::tools
