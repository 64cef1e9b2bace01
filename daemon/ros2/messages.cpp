// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros2/messages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include <Eigen/Geometry>
#include <cliquevo/status_t.hpp>
#include <fmt/format.h>

namespace cliquevo::ros2 {

namespace {

using drivers::CdrWriter;

void put(const Eigen::Vector3d& v, CdrWriter& out) { out.put(std::span(v.data(), 3)); }
// ROS has w last.
void put_quaternion(const Eigen::Vector4d& wxyz, CdrWriter& out) {
  out.put(wxyz[1]).put(wxyz[2]).put(wxyz[3]).put(wxyz[0]);
}
void put(const double (&M)[6][6], CdrWriter& out) {
  for (const auto& row : M) out.put(std::span(row));
}
Eigen::Vector3d vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }
Eigen::Vector4d quaternion(const double (&q)[4]) { return {q[0], q[1], q[2], q[3]}; }

// Within a block of bytes.
void put_floats(std::span<const float> values, CdrWriter& out) {
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    std::array<std::uint8_t, 4> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
    out.row(bytes);
  }
}

struct Lens {
  std::string_view model;
  std::vector<double> terms;
};
Lens lens_of(const CameraCalibration& c) {
  const auto first = [&](int count) {
    return std::vector<double>(c.coefficients.begin(), c.coefficients.begin() + count);
  };
  switch (c.distortion) {
    case Distortion::rational:
      return {"rational_polynomial", first(8)};
    case Distortion::equidistant:
      return {"equidistant", first(4)};
    case Distortion::thin_prism: {
      Lens out{"thin_prism", first(8)};
      out.terms.insert(out.terms.end(), c.prism.begin(), c.prism.end());
      return out;
    }
    case Distortion::unified:
      return {"omni", first(5)};
    case Distortion::extended_unified:
      return {"eucm", first(2)};
    case Distortion::double_sphere:
      return {"ds", first(2)};
    case Distortion::none:
    case Distortion::plumb_bob:
      break;
  }
  return {"plumb_bob", first(5)};
}

}  // namespace

std::string_view verdict_text(int status) {
  switch (status) {
    case status_t::NO_DATA:
      return "first frame";
    case status_t::VALID:
      return "valid";
    case status_t::TOO_FEW_FEATURES:
      return "too few features";
    case status_t::DEGENERATE:
      return "motion not fixed by the features";
    case status_t::REPROJECTION_ERROR:
      return "reprojection error too large";
    case status_t::AMBIGUOUS:
      return "a second motion is nearly as well supported";
    default:
      return "too uncertain";
  }
}

RigidTransform pose_of(const odometry_t& m) {
  RigidTransform T;
  const Eigen::Vector4d q = quaternion(m.orientation);
  T.R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  T.t = vector(m.position);
  return T;
}

void put_image(TimestampNs stamp_ns, std::string_view frame, ImageView<const std::uint8_t> image, CdrWriter& out) {
  out.clear();
  const auto width = static_cast<std::size_t>(image.width);
  out.header(stamp_ns, frame).put(static_cast<std::uint32_t>(image.height)).put(static_cast<std::uint32_t>(width));
  out.text("mono8").put(std::uint8_t{0}).put(static_cast<std::uint32_t>(width));
  out.begin_block(width * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) out.row({image.row(y), width});
}

void put_png(TimestampNs stamp_ns, std::string_view frame, std::span<const std::uint8_t> file, CdrWriter& out) {
  out.clear();
  out.header(stamp_ns, frame).text("png").block(file);
}

void put_disparity(TimestampNs stamp_ns, std::string_view frame, ImageView<const std::int16_t> disparity,
                   CdrWriter& out) {
  out.clear();
  const auto width = static_cast<std::uint32_t>(disparity.width);
  const auto height = static_cast<std::uint32_t>(disparity.height);
  out.header(stamp_ns, frame).put(height).put(width).text("32FC1").put(std::uint8_t{0}).put(4 * width);
  out.begin_block(std::size_t{4} * width * height);
  std::vector<float> row(width);
  for (int y = 0; y < disparity.height; ++y) {
    const std::int16_t* from = disparity.row(y);
    std::transform(from, from + width, row.begin(), [](std::int16_t sixteenths) {
      return sixteenths > 0 ? static_cast<float>(sixteenths) / 16.0F : std::numeric_limits<float>::quiet_NaN();
    });
    put_floats(row, out);
  }
}

void put_camera_info(TimestampNs stamp_ns, const StereoCalibration& calibration, bool left, CdrWriter& out) {
  const PrescribedRectification to = calibration.prescribed.value_or(PrescribedRectification{});
  const StereoModel& m = to.model;
  Eigen::Matrix3d R = left ? to.R_left : to.R_right;
  const double cx = left ? m.cx_px : m.cx_px + m.doffs_px;
  CameraCalibration c = left ? calibration.left : calibration.right;
  if (calibration.rectified) {
    R.setIdentity();
    c = {};
    c.width = m.width;
    c.height = m.height;
    c.fx_px = m.fx_px;
    c.fy_px = m.fy_px;
    c.cx_px = cx;
    c.cy_px = m.cy_px;
  }
  const Lens lens = lens_of(c);
  out.clear();
  out.header(stamp_ns, left ? kLeftFrame : kRightFrame);
  out.put(static_cast<std::uint32_t>(c.height)).put(static_cast<std::uint32_t>(c.width)).text(lens.model);
  out.put(static_cast<std::uint32_t>(lens.terms.size())).put(std::span<const double>(lens.terms));
  const std::array<double, 9> K{c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1};
  out.put(std::span<const double>(K));
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) out.put(R(r, k));
  }
  const double shift = left ? 0.0 : -m.fx_px * m.baseline_m;
  const std::array<double, 12> P{m.fx_px, 0, cx, shift, 0, m.fy_px, m.cy_px, 0, 0, 0, 1, 0};
  out.put(std::span<const double>(P)).put(std::uint32_t{0}).put(std::uint32_t{0});
  for (int i = 0; i < 4; ++i) out.put(std::uint32_t{0});  // region of interest: all
  out.put(std::uint8_t{0});
}

void put_odometry(const odometry_t& m, CdrWriter& out) {
  out.clear();
  out.header(m.utime * 1000, kOdomFrame).text(kBodyFrame);
  put(vector(m.position), out);
  put_quaternion(quaternion(m.orientation), out);
  put(m.pose_covariance, out);
  put(vector(m.velocity), out);
  put(vector(m.rotation_rate), out);
  put(m.twist_covariance, out);
}

void put_pose(TimestampNs stamp_ns, const Eigen::Vector3d& position, const Eigen::Vector4d& wxyz, CdrWriter& out) {
  out.clear();
  out.header(stamp_ns, kOdomFrame);
  put(position, out);
  put_quaternion(wxyz, out);
}

void put_transform(TimestampNs stamp_ns, std::string_view frame, std::string_view child, const RigidTransform& T,
                   CdrWriter& out) {
  out.clear();
  out.put(std::uint32_t{1});
  out.header(stamp_ns, frame).text(child);
  put(T.t, out);
  const Eigen::Quaterniond q(T.R);
  put_quaternion({q.w(), q.x(), q.y(), q.z()}, out);
}

namespace {

// Everything before the data: fields of a float each.
void begin_cloud(TimestampNs stamp_ns, std::string_view frame, std::span<const char* const> fields, std::size_t count,
                 CdrWriter& out) {
  constexpr std::uint8_t kFloat32 = 7;
  constexpr std::uint32_t kBytes = 4;
  const std::uint32_t step = kBytes * static_cast<std::uint32_t>(fields.size());
  const auto points = static_cast<std::uint32_t>(count);
  out.clear();
  out.header(stamp_ns, frame).put(std::uint32_t{1}).put(points);
  out.put(static_cast<std::uint32_t>(fields.size()));
  std::uint32_t offset = 0;
  for (const char* name : fields) {
    out.text(name).put(offset).put(kFloat32).put(std::uint32_t{1});
    offset += kBytes;
  }
  out.put(std::uint8_t{0}).put(step).put(step * points).begin_block(std::size_t{step} * count);
}

}  // namespace

void put_points(TimestampNs stamp_ns, std::string_view frame, std::span<const Eigen::Vector3f> points, CdrWriter& out) {
  begin_cloud(stamp_ns, frame, std::span(kPointFields).first<3>(), points.size(), out);
  for (const Eigen::Vector3f& p : points) put_floats(std::span(p.data(), 3), out);
  out.put(std::uint8_t{1});
}

std::size_t count_of(const points_t& m) {
  return std::min({m.x.size(), m.y.size(), m.z.size(), m.sigma.size(), m.grey.size()});
}

void put_points(const points_t& m, CdrWriter& out) {
  const std::size_t count = count_of(m);
  begin_cloud(m.utime * 1000, kBodyFrame, kPointFields, count, out);
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<float, kPointFields.size()> fields{m.x[i], m.y[i], m.z[i], m.sigma[i],
                                                        static_cast<float>(m.grey[i])};
    put_floats(fields, out);
  }
  out.put(std::uint8_t{1});
}

void put_diagnostics(const odometry_t& m, CdrWriter& out) {
  constexpr std::uint8_t kOk = 0;
  constexpr std::uint8_t kWarn = 1;
  const std::array<std::pair<std::string_view, std::string>, 3> values{
      {{"quality", fmt::format("{}", m.quality)},
       {"pose is a guess", m.pose_is_guess != 0 ? "yes" : "no"},
       {"reset counter", fmt::format("{}", m.reset_counter)}}};
  out.clear();
  out.header(m.utime * 1000, "").put(std::uint32_t{1});
  out.put(m.pose_is_guess != 0 ? kWarn : kOk);
  out.text("cliquevo: odometry").text(verdict_text(m.status)).text("cliquevo");
  out.put(static_cast<std::uint32_t>(values.size()));
  for (const auto& [key, value] : values) out.text(key).text(value);
}

}  // namespace cliquevo::ros2
