// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mavlink_messages.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::tools {

namespace {

// Y and Z change their signs, for positions, velocities and axes of rotation alike.
constexpr std::array<double, 6> kSigns{1.0, -1.0, -1.0, 1.0, -1.0, -1.0};

std::array<float, 3> turned(const double (&v)[3]) {
  std::array<float, 3> out{};
  for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(kSigns[i] * v[i]);
  return out;
}

std::array<float, 21> turned(const double (&covariance)[6][6]) {
  std::array<float, 21> out{};
  std::size_t k = 0;
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = r; c < 6; ++c) out[k++] = static_cast<float>(kSigns[r] * kSigns[c] * covariance[r][c]);
  }
  return out;
}

// Turning both frames about their X axis leaves w and x.
std::array<double, 4> turned_quaternion(const odometry_t& m) {
  return {m.orientation[0], m.orientation[1], -m.orientation[2], -m.orientation[3]};
}

}  // namespace

mavlink::Odometry mavlink_odometry(const odometry_t& m) {
  mavlink::Odometry out;
  out.time_usec = static_cast<std::uint64_t>(std::max<std::int64_t>(0, m.utime));
  out.position = turned(m.position);
  const std::array<double, 4> q = turned_quaternion(m);
  for (std::size_t i = 0; i < 4; ++i) out.q[i] = static_cast<float>(q[i]);
  out.velocity = turned(m.velocity);
  out.rates = turned(m.rotation_rate);
  out.pose_covariance = turned(m.pose_covariance);
  out.velocity_covariance = turned(m.twist_covariance);
  out.reset_counter = static_cast<std::uint8_t>(m.reset_counter);
  // 0 would say that the quality is not known.
  out.quality = m.pose_is_guess != 0 ? std::int8_t{-1} : std::max(std::int8_t{1}, m.quality);
  return out;
}

mavlink::VisionPosition mavlink_vision_position(const odometry_t& m) {
  mavlink::VisionPosition out;
  out.usec = static_cast<std::uint64_t>(std::max<std::int64_t>(0, m.utime));
  out.position = turned(m.position);
  const auto [w, x, y, z] = turned_quaternion(m);
  out.roll_pitch_yaw = {
      static_cast<float>(std::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))),
      static_cast<float>(std::asin(std::clamp(2.0 * (w * y - z * x), -1.0, 1.0))),
      static_cast<float>(std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))),
  };
  out.covariance = turned(m.pose_covariance);
  out.reset_counter = static_cast<std::uint8_t>(m.reset_counter);
  return out;
}

}  // namespace cliquevo::tools
