// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ros2/bridge.h"

#include <Ros.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "daemon/ros2/messages.h"
#include "tools/ros2/dds_writer.h"

namespace cliquevo::ros2 {

namespace {

using Header = std_msgs_msg_dds__Header_;
using Transform = geometry_msgs_msg_dds__TransformStamped_;

// The types' texts are not const, though nobody writes there.
char* text(std::string_view view) { return const_cast<char*>(view.data()); }

Header header(std::int64_t utime, std::string_view frame) {
  constexpr std::int64_t kSecond = 1'000'000;
  const std::int64_t rest = ((utime % kSecond) + kSecond) % kSecond;
  Header out{};
  out.stamp.sec = static_cast<std::int32_t>((utime - rest) / kSecond);
  out.stamp.nanosec = static_cast<std::uint32_t>(rest * 1000);
  out.frame_id = text(frame);
  return out;
}

Transform transform(std::int64_t utime, std::string_view frame, std::string_view child, const RigidTransform& T) {
  const Eigen::Quaterniond q(T.R);
  Transform out{};
  out.header = header(utime, frame);
  out.child_frame_id = text(child);
  out.transform.translation = {T.t.x(), T.t.y(), T.t.z()};
  out.transform.rotation = {q.x(), q.y(), q.z(), q.w()};
  return out;
}

void write_transform(dds_entity_t writer, Transform one) {
  tf2_msgs_msg_dds__TFMessage_ m{};
  m.transforms._maximum = m.transforms._length = 1;
  m.transforms._buffer = &one;
  dds_write(writer, &m);
}

bool is_whole(const image_t& image, int bytes_a_pixel) {
  return image.width > 0 && image.height > 0 && image.row_stride / bytes_a_pixel >= image.width &&
         image.data.size() >= static_cast<std::size_t>(image.row_stride) * static_cast<std::size_t>(image.height);
}

}  // namespace

struct Bridge::Impl {
  explicit Impl(DdsParticipant joined) : participant(std::move(joined)) {}

  // What is in `pixels`.
  void write_image(dds_entity_t writer, const image_t& image, std::string_view encoding, std::size_t step) {
    sensor_msgs_msg_dds__Image_ m{};
    m.header = header(image.utime, kLeftFrame);
    m.height = static_cast<std::uint32_t>(image.height);
    m.width = static_cast<std::uint32_t>(image.width);
    m.encoding = text(encoding);
    m.step = static_cast<std::uint32_t>(step);
    m.data._maximum = m.data._length = static_cast<std::uint32_t>(pixels.size());
    m.data._buffer = pixels.data();
    dds_write(writer, &m);
  }

  void publish_left(const image_t& image) {
    if (!is_whole(image, 1)) return;
    const auto step = static_cast<std::size_t>(image.row_stride);
    pixels.resize(step * static_cast<std::size_t>(image.height));
    std::memcpy(pixels.data(), image.data.data(), pixels.size());
    write_image(left, image, "mono8", step);
  }

  void publish_disparity(const image_t& image) {
    if (!is_whole(image, 2)) return;
    const auto width = static_cast<std::size_t>(image.width);
    pixels.resize(4 * width * static_cast<std::size_t>(image.height));
    std::uint8_t* to = pixels.data();
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) {
      const std::uint8_t* row = image.data.data() + y * static_cast<std::size_t>(image.row_stride);
      for (std::size_t x = 0; x < width; ++x, to += 4) {
        const unsigned sixteenths = row[2 * x] | static_cast<unsigned>(row[2 * x + 1]) << 8U;
        const float px =
            sixteenths == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(sixteenths) / 16.0F;
        std::memcpy(to, &px, sizeof px);
      }
    }
    write_image(disparity, image, "32FC1", 4 * width);
  }

  void publish_diagnostics(const odometry_t& m) const {
    const std::array<std::string, 3> texts{fmt::format("{}", m.quality), m.pose_is_guess != 0 ? "yes" : "no",
                                           fmt::format("{}", m.reset_counter)};
    std::array<diagnostic_msgs_msg_dds__KeyValue_, 3> values{{{text("quality"), text(texts[0])},
                                                              {text("pose is a guess"), text(texts[1])},
                                                              {text("reset counter"), text(texts[2])}}};
    diagnostic_msgs_msg_dds__DiagnosticStatus_ status{};
    status.level = m.pose_is_guess != 0 ? 1 : 0;
    status.name = text("cliquevo: odometry");
    status.message = text(verdict_text(m.status));
    status.hardware_id = text("cliquevo");
    status.values._maximum = status.values._length = static_cast<std::uint32_t>(values.size());
    status.values._buffer = values.data();
    diagnostic_msgs_msg_dds__DiagnosticArray_ all{};
    all.header = header(m.utime, "");
    all.status._maximum = all.status._length = 1;
    all.status._buffer = &status;
    dds_write(diagnostics, &all);
  }

  DdsParticipant participant;
  dds_entity_t odom = 0;
  dds_entity_t tf = 0;
  dds_entity_t tf_static = 0;
  dds_entity_t diagnostics = 0;
  dds_entity_t left = 0;
  dds_entity_t disparity = 0;
  dds_entity_t points = 0;
  std::vector<std::uint8_t> pixels;
};

Bridge::Bridge(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Bridge::Bridge(Bridge&&) noexcept = default;
Bridge& Bridge::operator=(Bridge&&) noexcept = default;
Bridge::~Bridge() = default;

Result<Bridge> Bridge::start(const BridgeOptions& options) {
  using Kind = DdsParticipant::Kind;
  auto participant = DdsParticipant::join(options.domain);
  if (!participant) return participant.error();
  auto impl = std::make_unique<Impl>(std::move(*participant));
  struct Wanted {
    dds_entity_t* writer;
    const dds_topic_descriptor_t* type;
    const char* topic;
    Kind kind;
    int depth;
  };
  std::vector<Wanted> all{
      {&impl->odom, &nav_msgs_msg_dds__Odometry__desc, "/odom", Kind::stream, 10},
      {&impl->tf, &tf2_msgs_msg_dds__TFMessage__desc, "/tf", Kind::stream, 100},
      {&impl->tf_static, &tf2_msgs_msg_dds__TFMessage__desc, "/tf_static", Kind::latched, 1},
      {&impl->diagnostics, &diagnostic_msgs_msg_dds__DiagnosticArray__desc, "/diagnostics", Kind::stream, 10}};
  if (options.images) {
    all.push_back({&impl->left, &sensor_msgs_msg_dds__Image__desc, "/stereo/left/image_rect", Kind::stream, 5});
    all.push_back({&impl->disparity, &sensor_msgs_msg_dds__Image__desc, "/stereo/disparity", Kind::stream, 5});
  }
  if (options.points) {
    all.push_back({&impl->points, &sensor_msgs_msg_dds__PointCloud2__desc, "/stereo/points2", Kind::stream, 5});
  }
  for (const Wanted& one : all) {
    const auto writer = impl->participant.add_writer(*one.type, one.topic, one.kind, one.depth);
    if (!writer) return writer.error();
    *one.writer = *writer;
  }
  write_transform(impl->tf_static, transform(0, kBodyFrame, kLeftFrame, options.T_body_camera));
  return Bridge(std::move(impl));
}

void Bridge::publish(const odometry_t& m) {
  nav_msgs_msg_dds__Odometry_ out{};
  out.header = header(m.utime, kOdomFrame);
  out.child_frame_id = text(kBodyFrame);
  out.pose.pose.position = {m.position[0], m.position[1], m.position[2]};
  out.pose.pose.orientation = {m.orientation[1], m.orientation[2], m.orientation[3], m.orientation[0]};
  out.twist.twist.linear = {m.velocity[0], m.velocity[1], m.velocity[2]};
  out.twist.twist.angular = {m.rotation_rate[0], m.rotation_rate[1], m.rotation_rate[2]};
  std::memcpy(out.pose.covariance, m.pose_covariance, sizeof out.pose.covariance);
  std::memcpy(out.twist.covariance, m.twist_covariance, sizeof out.twist.covariance);
  dds_write(impl_->odom, &out);
  write_transform(impl_->tf, transform(m.utime, kOdomFrame, kBodyFrame, pose_of(m)));
  impl_->publish_diagnostics(m);
}

void Bridge::publish(const images_t& m) {
  if (impl_->left == 0) return;
  for (std::size_t i = 0; i < std::min(m.images.size(), m.image_types.size()); ++i) {
    if (m.image_types[i] == images_t::LEFT) impl_->publish_left(m.images[i]);
    if (m.image_types[i] == images_t::DISPARITY) impl_->publish_disparity(m.images[i]);
  }
}

void Bridge::publish(const points_t& m) {
  if (impl_->points == 0) return;
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint32_t kStep = 4 * kPointFields.size();
  const std::size_t count = count_of(m);
  std::array<sensor_msgs_msg_dds__PointField_, kPointFields.size()> fields{};
  for (std::size_t k = 0; k < fields.size(); ++k) {
    fields[k] = {text(kPointFields[k]), static_cast<std::uint32_t>(4 * k), kFloat32, 1};
  }
  std::vector<std::uint8_t>& data = impl_->pixels;
  data.resize(kStep * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, kPointFields.size()> values{m.x[i], m.y[i], m.z[i], m.sigma[i],
                                                        static_cast<float>(m.grey[i])};
    std::memcpy(data.data() + kStep * i, values.data(), kStep);
  }
  sensor_msgs_msg_dds__PointCloud2_ out{};
  out.header = header(m.utime, kBodyFrame);
  out.height = 1;
  out.width = static_cast<std::uint32_t>(count);
  out.fields._maximum = out.fields._length = static_cast<std::uint32_t>(fields.size());
  out.fields._buffer = fields.data();
  out.point_step = kStep;
  out.row_step = kStep * out.width;
  out.data._maximum = out.data._length = static_cast<std::uint32_t>(data.size());
  out.data._buffer = data.data();
  out.is_dense = true;
  dds_write(impl_->points, &out);
}

}  // namespace cliquevo::ros2
