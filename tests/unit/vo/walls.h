// SPDX-License-Identifier: BSD-3-Clause
// Two textured walls that face the camera, one above the other: what a camera sees of them from any place to the side
// can be written down, to any fraction of a pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/vo/visual_odometry.h"

namespace cliquevo::vo {

class Walls {
 public:
  static constexpr double kFar_px = 8.0;    // disparity of the upper wall
  static constexpr double kNear_px = 20.0;  // and of the lower one
  static constexpr std::int64_t kPeriod_ns = 100'000'000;

  struct Views {
    Image<std::uint8_t> left, right, filtered;
    Image<std::int16_t> disparity;
    FrameInput input(std::int64_t frame) const {
      return {frame * kPeriod_ns, left.cview(), right.cview(), filtered.cview(), disparity.cview()};
    }
  };
  // Where the camera is, and what is wrong with it.
  struct Place {
    double x_m = 0.0;
    double y_m = 0.0;
    double gain = 1.0;
    double right_lower_px = 0.0;  // rows by which the right image is lower
    double right_half_x_m = 0.0;  // by which all that is right of the middle has moved
  };

  static StereoModel model() { return {320, 240, 300.0, 300.0, 159.5, 119.5, 0.2, 0.0}; }
  static double disparity_px(double row) { return row < 120 ? kFar_px : kNear_px; }

  explicit Walls(unsigned seed = 1) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> frequency(-0.9, 0.9), phase(0.0, 6.28);
    for (auto& w : waves_) w = {frequency(rng), frequency(rng), phase(rng)};
  }

  Views from(const Place& place) const {
    const StereoModel m = model();
    Views v;
    v.left.resize(m.width, m.height);
    v.right.resize(m.width, m.height);
    v.filtered.resize(m.width, m.height);
    v.disparity.resize(m.width, m.height);
    for (int row = 0; row < m.height; ++row) {
      const double d = disparity_px(row);
      const double px_per_m = m.fx_px / m.depth_m(d);
      for (int column = 0; column < m.width; ++column) {
        const double x_m = place.x_m - (2 * column >= m.width ? place.right_half_x_m : 0.0);
        const double u = column + x_m * px_per_m;
        const double w = row + place.y_m * px_per_m;
        v.left.view()(column, row) = grey(u, w, d, place.gain);
        v.right.view()(column, row) = grey(u + d, w - place.right_lower_px, d, place.gain);
        v.filtered.view()(column, row) = static_cast<std::uint8_t>(v.left.view()(column, row) / 4);
        v.disparity.view()(column, row) = static_cast<std::int16_t>(d * kDisparityScale);
      }
    }
    return v;
  }
  Views from(double x_m, double y_m, double gain = 1.0) const { return from({.x_m = x_m, .y_m = y_m, .gain = gain}); }

 private:
  struct Wave {
    double fx, fy, phase;
  };
  std::uint8_t grey(double u, double v, double wall, double gain) const {
    double sum = 0.0;
    for (const Wave& w : waves_) sum += std::sin(w.fx * u + w.fy * v + w.phase + wall);
    return static_cast<std::uint8_t>(std::lround(std::clamp(gain * (110.0 + 22.0 * sum), 0.0, 255.0)));
  }
  Wave waves_[14];
};

}  // namespace cliquevo::vo
