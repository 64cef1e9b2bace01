// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/raw_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace cliquevo::drivers::sim {

namespace {

constexpr int kOversampling = 2;

CameraCalibration lens(const SimulatorOptions& o, double fx, double fy, double off_x, double off_y,
                       std::array<double, 8> coefficients) {
  CameraCalibration c;
  c.width = o.width;
  c.height = o.height;
  c.fx_px = fx * o.focal_px;
  c.fy_px = fy * o.focal_px;
  // Of the image's size: a hundredth of its width at most.
  c.cx_px = 0.5 * (o.width - 1) + off_x * o.width;
  c.cy_px = 0.5 * (o.height - 1) + off_y * o.width;
  c.distortion = Distortion::plumb_bob;
  c.coefficients = coefficients;
  return c;
}

Eigen::Vector2d distort(const CameraCalibration& c, const Eigen::Vector2d& p, Eigen::Matrix2d* slope) {
  const double k1 = c.coefficients[0];
  const double k2 = c.coefficients[1];
  const double p1 = c.coefficients[2];
  const double p2 = c.coefficients[3];
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + k1 * r2 + k2 * r2 * r2;
  if (slope != nullptr) {
    const double change = 2.0 * (k1 + 2.0 * k2 * r2);  // of radial, per x (times x) and per y (times y)
    (*slope)(0, 0) = radial + change * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
    (*slope)(0, 1) = change * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    (*slope)(1, 0) = (*slope)(0, 1);
    (*slope)(1, 1) = radial + change * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

// Newton's method; the options' check keeps the field of view where the lens is monotonic.
Eigen::Vector2d undistort(const CameraCalibration& c, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix2d slope;
    const Eigen::Vector2d error = distort(c, p, &slope) - distorted;
    const Eigen::Vector2d step = slope.inverse() * error;
    p -= step;
    if (step.squaredNorm() < 1e-26) break;
  }
  return p;
}

// Cubic B-spline.
double spline(double x) {
  x = std::abs(x);
  if (x >= 2.0) return 0.0;
  if (x >= 1.0) return (2.0 - x) * (2.0 - x) * (2.0 - x) / 6.0;
  return (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0;
}

// Two pinhole pixels make the width of a raw one; the spline around them is the lens. Sums to 1 at every fraction.
double kernel(double x) { return 0.5 * (spline(x - 0.5) + spline(x + 0.5)); }

const std::vector<std::array<float, 5>>& kernel_weights(int fractions) {
  static const std::vector<std::array<float, 5>> kTable = [&] {
    std::vector<std::array<float, 5>> table(static_cast<std::size_t>(fractions));
    for (int i = 0; i < fractions; ++i) {
      // The first tap lies between 2.5 and 1.5 before the place.
      for (int k = 0; k < 5; ++k) {
        table[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
            static_cast<float>(kernel(k - 1.5 - (i + 0.5) / fractions));
      }
    }
    return table;
  }();
  return kTable;
}

}  // namespace

StereoModel rectified_model(const SimulatorOptions& o) {
  StereoModel m;
  m.width = o.width;
  m.height = o.height;
  m.fx_px = m.fy_px = o.focal_px;
  m.cx_px = 0.5 * (o.width - 1);
  m.cy_px = 0.5 * (o.height - 1);
  m.baseline_m = o.baseline_m;
  return m;
}

StereoCalibration simulated_calibration(const SimulatorOptions& o) {
  StereoCalibration c;
  c.source = "simulator";
  c.readout_s = 1e-3 * std::max(o.readout_ms, 0.0);
  PrescribedRectification prescribed;
  prescribed.model = rectified_model(o);
  c.rectified = !o.raw;
  if (o.raw) {
    c.left = lens(o, 0.9914, 0.9927, 0.0045, -0.0033, {-0.281, 0.083, 0.0004, -0.0002});
    c.right = lens(o, 0.9930, 0.9918, -0.0037, 0.0023, {-0.276, 0.079, -0.0003, 0.0005});
    const Eigen::Vector3d turn = Eigen::Vector3d(0.20, -0.32, 0.26) * (std::numbers::pi / 180.0);
    prescribed.R_left = so3_exp(turn);
    prescribed.R_right = so3_exp(-turn);
  } else {
    c.left.width = c.right.width = o.width;
    c.left.height = c.right.height = o.height;
    c.left.fx_px = c.left.fy_px = c.right.fx_px = c.right.fy_px = o.focal_px;
    c.left.cx_px = c.right.cx_px = prescribed.model.cx_px;
    c.left.cy_px = c.right.cy_px = prescribed.model.cy_px;
  }
  // p_right = R_right^T (R_left p_left - baseline along X)
  c.T_right_left.R = prescribed.R_right.transpose() * prescribed.R_left;
  c.T_right_left.t = prescribed.R_right.transpose() * Eigen::Vector3d(-o.baseline_m, 0.0, 0.0);
  c.prescribed = prescribed;
  return c;
}

RawCamera::RawCamera(const CameraCalibration& camera) : raw_width_(camera.width), raw_height_(camera.height) {
  std::vector<Eigen::Vector2d> rays;
  rays.reserve(static_cast<std::size_t>(raw_width_) * static_cast<std::size_t>(raw_height_));
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (int v = 0; v < raw_height_; ++v) {
    for (int u = 0; u < raw_width_; ++u) {
      rays.push_back(undistort(camera, {(u - camera.cx_px) / camera.fx_px, (v - camera.cy_px) / camera.fy_px}));
      low = low.cwiseMin(rays.back());
      high = high.cwiseMax(rays.back());
    }
  }
  focal_px_ = kOversampling * 0.5 * (camera.fx_px + camera.fy_px);
  constexpr double kMargin = 4.0;
  cx_px_ = std::ceil(kMargin - low.x() * focal_px_);
  cy_px_ = std::ceil(kMargin - low.y() * focal_px_);
  width_ = static_cast<int>(std::ceil(high.x() * focal_px_ + cx_px_ + kMargin)) + 1;
  height_ = static_cast<int>(std::ceil(high.y() * focal_px_ + cy_px_ + kMargin)) + 1;
  map_.reserve(rays.size());
  for (const Eigen::Vector2d& ray : rays) {
    const double u = ray.x() * focal_px_ + cx_px_ - 1.5;
    const double v = ray.y() * focal_px_ + cy_px_ - 1.5;
    const double iu = std::floor(u);
    const double iv = std::floor(v);
    // Tap 0 lies 1.5 + fraction before the place.
    map_.push_back({static_cast<std::int32_t>(iv) * width_ + static_cast<std::int32_t>(iu),
                    static_cast<std::int16_t>((u - iu) * kFractions),
                    static_cast<std::int16_t>((v - iv) * kFractions)});
  }
}

void RawCamera::resample(const std::vector<float>& pinhole, float scale, float limit, Image<std::uint16_t>& raw) const {
  const auto& weights = kernel_weights(kFractions);
  raw.resize(raw_width_, raw_height_);
  const Source* source = map_.data();
  for (int v = 0; v < raw_height_; ++v) {
    std::uint16_t* row = raw.view().row(v);
    for (int u = 0; u < raw_width_; ++u, ++source) {
      const auto& wx = weights[static_cast<std::size_t>(source->fx)];
      const auto& wy = weights[static_cast<std::size_t>(source->fy)];
      const float* p = pinhole.data() + source->start;
      float sum = 0.0F;
      for (int b = 0; b < kTaps; ++b, p += width_) {
        const float line = (wx[0] * p[0] + wx[1] * p[1]) + (wx[2] * p[2] + wx[3] * p[3]) + wx[4] * p[4];
        sum += wy[static_cast<std::size_t>(b)] * line;
      }
      row[u] = static_cast<std::uint16_t>(std::clamp(sum * scale + 0.5F, 0.0F, limit));
    }
  }
}

}  // namespace cliquevo::drivers::sim
