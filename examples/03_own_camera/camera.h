// SPDX-License-Identifier: BSD-3-Clause
// Stands for the driver of a camera that delivers both images side by side in one buffer, as grabbed: distorted, the
// right camera turned a little against the left one.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <cliquevo/camera_model.h>
#include <cliquevo/time.h>

class Camera {
 public:
  static constexpr int kWidth = 320;
  static constexpr int kHeight = 240;
  static constexpr double kStepM = 0.1;

  // What a calibration program prints about such a camera.
  static cliquevo::StereoCalibration calibration() {
    cliquevo::CameraCalibration one;
    one.width = kWidth;
    one.height = kHeight;
    one.fx_px = one.fy_px = 300.0;
    one.cx_px = 159.5;
    one.cy_px = 119.5;
    one.distortion = cliquevo::Distortion::plumb_bob;
    one.coefficients = {-0.1, 0.02};
    cliquevo::StereoCalibration out;
    out.left = out.right = one;
    out.T_right_left.R = cliquevo::so3_exp({0.005, -0.003, 0.004});
    out.T_right_left.t = out.T_right_left.R * Eigen::Vector3d(-0.12, 0.0, 0.0);
    return out;
  }

  Camera() : calibration_(calibration()), buffer_(static_cast<std::size_t>(2 * kWidth * kHeight)) {}

  // Both images of the next instant, rows of 2 * kWidth pixels: left, then right.
  const std::uint8_t* grab(cliquevo::TimestampNs& stamp_ns) {
    draw({}, buffer_.data());
    draw(calibration_.T_right_left, buffer_.data() + kWidth);
    stamp_ns = frame_ * std::int64_t{100'000'000};
    ++frame_;
    return buffer_.data();
  }

 private:
  static double grey(double x, double y) {
    return 128.0 + 40.0 * std::sin(23.0 * x + 5.0 * std::sin(7.1 * y)) +
           40.0 * std::sin(19.0 * y + 5.0 * std::sin(9.7 * x)) + 30.0 * std::sin(61.0 * x + 47.0 * y);
  }
  // Direction that a pixel looks in: the distortion turned round step by step.
  Eigen::Vector3d ray(int u, int v) const {
    const cliquevo::CameraCalibration& c = calibration_.left;
    const Eigen::Vector2d seen((u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px);
    Eigen::Vector2d p = seen;
    for (int i = 0; i < 10; ++i) {
      const double r2 = p.squaredNorm();
      p = seen / (1.0 + r2 * (c.coefficients[0] + r2 * c.coefficients[1]));
    }
    return {p.x(), p.y(), 1.0};
  }
  // The wall Z = 3 + 0.3 X, which comes nearer by kStepM a frame.
  void draw(const cliquevo::RigidTransform& T_camera_left, std::uint8_t* first) const {
    const cliquevo::RigidTransform T_left_camera = T_camera_left.inverse();
    const Eigen::Vector3d from = T_left_camera.t;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const Eigen::Vector3d d = T_left_camera.R * ray(u, v);
        const double along = (3.0 - kStepM * frame_ + 0.3 * from.x() - from.z()) / (d.z() - 0.3 * d.x());
        const Eigen::Vector3d hit = from + along * d;
        first[2 * kWidth * v + u] = static_cast<std::uint8_t>(grey(hit.x(), hit.y()));
      }
    }
  }

  cliquevo::StereoCalibration calibration_;
  std::vector<std::uint8_t> buffer_;
  int frame_ = 0;
};
