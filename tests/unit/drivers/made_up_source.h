// SPDX-License-Identifier: BSD-3-Clause
// A camera that delivers made-up pairs: each of its pixels holds the number of its pair.
#pragma once

#include <cstdint>

#include "drivers/frame_source.h"

namespace cliquevo::test {

inline drivers::SourceInfo made_up_info(int width = 64, int height = 48) {
  drivers::SourceInfo info;
  info.description = "made-up rig";
  info.width = width;
  info.height = height;
  info.rate_hz = 30.0;
  StereoCalibration& c = info.calibration;
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    camera->width = width;
    camera->height = height;
    camera->fx_px = 61.0 + 1.0 / 3.0;
    camera->fy_px = 60.9;
    camera->cx_px = width / 2.0 - 0.7;
    camera->cy_px = height / 2.0 + 0.3;
    camera->distortion = Distortion::plumb_bob;
    camera->coefficients = {-0.1, 0.01, 1e-4, -2e-4, 0.003, 0, 0, 0};
  }
  c.right.fx_px += 0.5;
  c.T_right_left.R = so3_exp({0.01, -0.02, 0.003});
  c.T_right_left.t = {-0.12, 0.001, 0.0005};
  c.source = "/made/up.yaml";
  return info;
}

inline std::uint8_t made_up_pixel(int x, int y, std::int64_t index, bool left) {
  return static_cast<std::uint8_t>(7 * x + 13 * y + 31 * index + (left ? 0 : 101) + (x * y) / 5);
}

inline void make_up_pair(std::int64_t index, const drivers::SourceInfo& info, drivers::StereoPair& pair) {
  pair.index = index;
  pair.stamp_ns = 1'700'000'000'000'000'123 + index * 33'333'333;
  pair.right_offset_ns = 1234;
  pair.host_ns = pair.stamp_ns + 5'000'017;
  for (const bool left : {true, false}) {
    Image<std::uint8_t>& image = left ? pair.left : pair.right;
    image.resize(info.width, info.height);
    for (int y = 0; y < info.height; ++y) {
      for (int x = 0; x < info.width; ++x) image.view()(x, y) = made_up_pixel(x, y, index, left);
    }
  }
}

// The number of the pair that these images show; -1: of none, or not whole.
inline std::int64_t shown_pair(const drivers::StereoPair& pair, std::int64_t candidates) {
  for (std::int64_t index = 0; index < candidates; ++index) {
    bool same = true;
    for (const bool left : {true, false}) {
      const ImageView<const std::uint8_t> view = left ? pair.left.cview() : pair.right.cview();
      for (int y = 0; y < view.height && same; ++y) {
        for (int x = 0; x < view.width && same; ++x) same = view(x, y) == made_up_pixel(x, y, index, left);
      }
    }
    if (same) return index;
  }
  return -1;
}

}  // namespace cliquevo::test
