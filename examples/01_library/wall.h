// SPDX-License-Identifier: BSD-3-Clause
// Stands for a stereo camera: a slanted, textured wall that comes nearer by 10 cm a frame.
#pragma once

#include <cmath>
#include <cstdint>

#include <cliquevo/camera_model.h>
#include <cliquevo/image.h>
#include <cliquevo/time.h>

class Wall {
 public:
  static constexpr double kStepM = 0.1;

  Wall(const cliquevo::StereoModel& model, int frames)
      : model_(model), frames_(frames), left_(model.width, model.height), right_(model.width, model.height) {}

  bool next() {
    if (++frame_ >= frames_) return false;
    draw(0.0, left_);
    draw(model_.baseline_m, right_);
    return true;
  }
  cliquevo::ImageView<const std::uint8_t> left() const { return left_.view(); }
  cliquevo::ImageView<const std::uint8_t> right() const { return right_.view(); }
  cliquevo::TimestampNs stamp_ns() const { return frame_ * std::int64_t{100'000'000}; }
  double way_m() const { return kStepM * frame_; }

 private:
  // Smooth texture without a period; x and y in m on the wall.
  static double grey(double x, double y) {
    return 128.0 + 40.0 * std::sin(23.0 * x + 5.0 * std::sin(7.1 * y)) +
           40.0 * std::sin(19.0 * y + 5.0 * std::sin(9.7 * x)) + 30.0 * std::sin(61.0 * x + 47.0 * y);
  }
  // As a camera sees it that sits camera_x to the right of the left one. Wall: Z = 3 + 0.3 X.
  void draw(double camera_x, cliquevo::Image<std::uint8_t>& image) const {
    for (int v = 0; v < model_.height; ++v) {
      for (int u = 0; u < model_.width; ++u) {
        const double rx = (u - model_.cx_px) / model_.fx_px;
        const double ry = (v - model_.cy_px) / model_.fy_px;
        const double z = (3.0 + 0.3 * camera_x - way_m()) / (1.0 - 0.3 * rx);
        image.view()(u, v) = static_cast<std::uint8_t>(grey(camera_x + rx * z, ry * z));
      }
    }
  }

  cliquevo::StereoModel model_;
  int frames_;
  int frame_ = -1;
  cliquevo::Image<std::uint8_t> left_;
  cliquevo::Image<std::uint8_t> right_;
};
