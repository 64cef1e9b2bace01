// SPDX-License-Identifier: BSD-3-Clause
// Messages of a daemon, made up: every field of each differs from every other's.
#pragma once

#include <cmath>

#include <cliquevo/images_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>

namespace cliquevo::test {

inline constexpr std::int64_t kFirstUs = 1'700'000'000'000'000;

inline odometry_t odometry_at(int n) {
  odometry_t m{};
  m.utime = kFirstUs + std::int64_t{n} * 33'333;
  const double half = 0.001 * (n + 1);
  m.orientation[0] = std::cos(half);
  m.orientation[3] = std::sin(half);
  for (int i = 0; i < 3; ++i) {
    m.position[i] = 0.1 * n + i / 3.0;
    m.velocity[i] = n - i / 7.0;
    m.rotation_rate[i] = n / 11.0 + i;
  }
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      m.pose_covariance[r][c] = 1.0 / (1 + r + c + n);
      m.twist_covariance[r][c] = 1.0 / (3 + r * c + n);
    }
  }
  m.quality = static_cast<std::int8_t>(n % 101);
  m.pose_is_guess = n % 7 == 3 ? 1 : 0;
  m.status = m.pose_is_guess != 0 ? 2 : 1;
  m.reset_counter = n / 50;
  return m;
}

inline image_t image(int n, int bytes_a_pixel, std::int32_t format, int width = 40, int height = 30) {
  image_t out{};
  out.utime = odometry_at(n).utime;
  out.width = width;
  out.height = height;
  out.pixelformat = format;
  out.row_stride = out.width * bytes_a_pixel;
  out.size = out.row_stride * out.height;
  for (int i = 0; i < out.size; ++i) out.data.push_back(static_cast<std::uint8_t>(i * 7 + n));
  return out;
}

inline images_t images_at(int n) {
  images_t m{};
  m.utime = odometry_at(n).utime;
  m.n_images = 2;
  m.image_types = {images_t::LEFT, images_t::DISPARITY};
  m.images = {image(n, 1, image_t::PIXEL_FORMAT_GRAY), image(n, 2, image_t::PIXEL_FORMAT_LE_GRAY16)};
  m.images[1].data[0] = m.images[1].data[1] = 0;  // unknown
  return m;
}

inline points_t points_at(int n) {
  points_t m{};
  m.utime = odometry_at(n).utime;
  m.num_points = 2000 + n;  // of more than one datagram's size in places
  for (int i = 0; i < m.num_points; ++i) {
    m.x.push_back(static_cast<float>(i) / 7.0F);
    m.y.push_back(static_cast<float>(n) - static_cast<float>(i) / 3.0F);
    m.z.push_back(-0.1F * static_cast<float>(i));
    m.sigma.push_back(0.01F * static_cast<float>(1 + i));
    m.grey.push_back(static_cast<std::uint8_t>(i + n));
  }
  return m;
}

}  // namespace cliquevo::test
