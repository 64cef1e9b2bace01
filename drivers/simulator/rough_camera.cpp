// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/rough_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/simulator/hash.h"
#include "drivers/simulator/renderer.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kPi = std::numbers::pi;
// Of what shakes the whole camera. Its blur is made up during so long an exposure: with a rolling shutter the rows are
// displaced by as much as follows from that speed and frequency.
constexpr double kVibrationHz = 60.0;
constexpr double kVibrationExposureS = 0.010;

// Standard normal, near enough: of twelve uniform ones.
double normal(std::uint64_t seed, std::int64_t node) {
  Random random(hash_cell(seed, node, 0));
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

// A smooth process in time with mean 0 and deviation 1: normal numbers at nodes, joined by cubic B-splines.
double smooth_noise(std::uint64_t seed, double nodes) {
  const double first = std::floor(nodes);
  const double t = nodes - first;
  const double u = 1.0 - t;
  const double weights[4] = {u * u * u / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                             (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0, t * t * t / 6.0};
  double sum = 0.0;
  double squares = 0.0;
  for (int k = 0; k < 4; ++k) {
    sum += weights[k] * normal(seed, static_cast<std::int64_t>(first) - 1 + k);
    squares += weights[k] * weights[k];
  }
  return sum / std::sqrt(squares);
}

// Catmull-Rom: passes through the samples.
void cubic_weights(float t, float (&w)[4]) {
  w[0] = 0.5F * t * (t * (2.0F - t) - 1.0F);
  w[1] = 0.5F * (t * t * (3.0F * t - 5.0F) + 2.0F);
  w[2] = 0.5F * t * (t * (4.0F - 3.0F * t) + 1.0F);
  w[3] = 0.5F * t * t * (t - 1.0F);
}

float sample(const PaddedPicture& picture, double x, double y) {
  // As far as the padding goes.
  x = std::clamp(x, -30.0, picture.width() + 29.0);
  y = std::clamp(y, -30.0, picture.height() + 29.0);
  const double fx = std::floor(x);
  const double fy = std::floor(y);
  float wx[4];
  float wy[4];
  cubic_weights(static_cast<float>(x - fx), wx);
  cubic_weights(static_cast<float>(y - fy), wy);
  float sum = 0.0F;
  for (int k = 0; k < 4; ++k) {
    const float* p = picture.row(static_cast<int>(fy) - 1 + k) + static_cast<int>(fx) - 1;
    sum += wy[k] * ((wx[0] * p[0] + wx[1] * p[1]) + (wx[2] * p[2] + wx[3] * p[3]));
  }
  return sum;
}

// Where a rolling shutter's row sees what the picture of the exposure's middle shows elsewhere. Turns are exact; for
// the way driven meanwhile everything below the horizon is taken for level ground under the camera.
class RowView {
 public:
  RowView(const SimulatorOptions& o, const Course& course, std::int64_t frame, int camera, double later_s)
      : focal_(o.focal_px), cx_(0.5 * (o.width - 1)), cy_(0.5 * (o.height - 1)) {
    const RigidTransform middle = course.T_world_camera(static_cast<double>(frame));
    const RigidTransform now = course.T_world_camera(static_cast<double>(frame) + later_s * o.rate_hz);
    T_middle_now_ = middle.inverse() * now;
    if (camera == 1) {
      const Eigen::Vector3d baseline(o.baseline_m, 0.0, 0.0);
      T_middle_now_.t += T_middle_now_.R * baseline - baseline;
    }
    down_per_m_ = now.R.transpose() * Eigen::Vector3d(0.0, 0.0, -1.0 / o.camera_height_m);
  }

  void source(double x, double y, double& u, double& v) const {
    const Eigen::Vector3d ray((x - cx_) / focal_, (y - cy_) / focal_, 1.0);
    const double nearness = std::max(down_per_m_.dot(ray), 0.0);  // 1/depth of the ground
    const Eigen::Vector3d p = T_middle_now_.R * ray + T_middle_now_.t * nearness;
    u = p.x() / p.z() * focal_ + cx_;
    v = p.y() / p.z() * focal_ + cy_;
  }

 private:
  double focal_, cx_, cy_;
  RigidTransform T_middle_now_;
  Eigen::Vector3d down_per_m_;
};

void roll(const SimulatorOptions& o, const Course& course, std::int64_t frame, int camera, const CameraShake& shake,
          const Vibration& vibration, const PaddedPicture& from, PaddedPicture& to) {
  const double amplitude = 1.0 / (2.0 * kPi * kVibrationHz * kVibrationExposureS);
  for (int j = 0; j < from.height(); ++j) {
    const double later_s = 1e-3 * o.readout_ms * ((j + 0.5) / from.height() - 0.5);
    const RowView row(o, course, frame, camera, later_s);
    const double swing = amplitude * std::sin(2.0 * kPi * kVibrationHz * later_s);
    const double right = shake.disparity_px - swing * vibration.x_px;
    const double down = -shake.rows_px - swing * vibration.y_px;
    float* out = to.row(j);
    for (int i = 0; i < from.width(); ++i) {
      double u = 0.0;
      double v = 0.0;
      row.source(i, j, u, v);
      out[i] = sample(from, u + right, v + down);
    }
  }
}

void shift(const CameraShake& shake, const PaddedPicture& from, PaddedPicture& to) {
  for (int j = 0; j < from.height(); ++j) {
    float* out = to.row(j);
    for (int i = 0; i < from.width(); ++i) out[i] = sample(from, i + shake.disparity_px, j - shake.rows_px);
  }
}

// The mean along a straight line through each pixel, which is its middle.
void blur_along(const Vibration& way, const PaddedPicture& from, PaddedPicture& to) {
  const int half = static_cast<int>(std::ceil(std::hypot(way.x_px, way.y_px)));
  const int count = 2 * half + 1;
  const float share = 1.0F / static_cast<float>(count);
  for (int j = 0; j < from.height(); ++j) std::fill(to.row(j), to.row(j) + to.width(), 0.0F);
  for (int k = -half; k <= half; ++k) {
    const double x = way.x_px * k / (2.0 * half);
    const double y = way.y_px * k / (2.0 * half);
    const auto ix = static_cast<int>(std::floor(x));
    const auto iy = static_cast<int>(std::floor(y));
    const auto ax = static_cast<float>(x - ix);
    const auto ay = static_cast<float>(y - iy);
    const float w[4] = {share * (1.0F - ax) * (1.0F - ay), share * ax * (1.0F - ay), share * (1.0F - ax) * ay,
                        share * ax * ay};
    for (int j = 0; j < from.height(); ++j) {
      const float* p = from.row(j + iy) + ix;
      const float* q = from.row(j + iy + 1) + ix;
      float* out = to.row(j);
      for (int i = 0; i < from.width(); ++i)
        out[i] += (w[0] * p[i] + w[1] * p[i + 1]) + (w[2] * q[i] + w[3] * q[i + 1]);
    }
  }
}

void defocus(double sigma_px, PaddedPicture& from, PaddedPicture& to) {
  const int radius = static_cast<int>(std::ceil(3.0 * sigma_px));
  std::vector<float> weights(static_cast<std::size_t>(radius) + 1);
  double sum = 0.0;
  for (int k = -radius; k <= radius; ++k) sum += std::exp(-0.5 * k * k / (sigma_px * sigma_px));
  for (int k = 0; k <= radius; ++k) {
    weights[static_cast<std::size_t>(k)] = static_cast<float>(std::exp(-0.5 * k * k / (sigma_px * sigma_px)) / sum);
  }
  for (int j = 0; j < from.height(); ++j) {
    const float* p = from.row(j);
    float* out = to.row(j);
    for (int i = 0; i < from.width(); ++i) out[i] = weights[0] * p[i];
    for (int k = 1; k <= radius; ++k)
      for (int i = 0; i < from.width(); ++i) out[i] += weights[static_cast<std::size_t>(k)] * (p[i - k] + p[i + k]);
  }
  to.pad();
  std::swap(from, to);
  for (int j = 0; j < from.height(); ++j) {
    const float* p = from.row(j);
    float* out = to.row(j);
    for (int i = 0; i < from.width(); ++i) out[i] = weights[0] * p[i];
    for (int k = 1; k <= radius; ++k) {
      const float* above = from.row(j - k);
      const float* below = from.row(j + k);
      for (int i = 0; i < from.width(); ++i) out[i] += weights[static_cast<std::size_t>(k)] * (above[i] + below[i]);
    }
  }
}

}  // namespace

void PaddedPicture::resize(int width, int height) {
  if (width == width_ && height == height_) return;
  width_ = width;
  height_ = height;
  stride_ = width + 2 * kPad;
  data_.assign(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2 * kPad), 0.0F);
}

void PaddedPicture::pad() {
  for (int j = 0; j < height_; ++j) {
    float* p = row(j);
    std::fill(p - kPad, p, p[0]);
    std::fill(p + width_, p + width_ + kPad, p[width_ - 1]);
  }
  for (int j = 1; j <= kPad; ++j) {
    std::copy_n(row(0) - kPad, stride_, row(-j) - kPad);
    std::copy_n(row(height_ - 1) - kPad, stride_, row(height_ - 1 + j) - kPad);
  }
}

Vibration vibration_of(const SimulatorOptions& o, std::int64_t frame) {
  if (o.vibration_px <= 0.0) return {0.0, 0.0};
  Random random(hash_cell(mix64(o.noise_seed ^ 0x7669627261ULL), frame, 0));
  const double length = random.uniform(0.0, o.vibration_px);
  const double angle = random.uniform(0.0, kPi);
  return {length * std::cos(angle), length * std::sin(angle)};
}

CameraShake shake_of(const SimulatorOptions& o, std::int64_t frame) {
  const double nodes = static_cast<double>(frame) / o.rate_hz * o.shake_hz;
  CameraShake shake;
  if (o.shake_px > 0.0) shake.disparity_px = o.shake_px * smooth_noise(mix64(o.noise_seed ^ 0x7368616b65ULL), nodes);
  if (o.shake_rows_px > 0.0) shake.rows_px = o.shake_rows_px * smooth_noise(mix64(o.noise_seed ^ 0x726f7773ULL), nodes);
  return shake;
}

ImageView<const std::uint16_t> roughen(const SimulatorOptions& o, const Course& course, std::int64_t frame, int camera,
                                       ImageView<const std::uint16_t> clean, RoughScratch& scratch) {
  const Vibration vibration = vibration_of(o, frame);
  const CameraShake shake = camera == 1 ? shake_of(o, frame) : CameraShake{};
  const bool rolls = o.readout_ms > 0.0;
  const bool shakes = shake.disparity_px != 0.0 || shake.rows_px != 0.0;
  const bool vibrates = vibration.x_px != 0.0 || vibration.y_px != 0.0;
  if (!rolls && !shakes && !vibrates && o.defocus_px <= 0.0) return clean;
  scratch.from.resize(clean.width, clean.height);
  scratch.to.resize(clean.width, clean.height);
  for (int j = 0; j < clean.height; ++j) {
    const std::uint16_t* in = clean.row(j);
    std::transform(in, in + clean.width, scratch.from.row(j), [](std::uint16_t v) { return static_cast<float>(v); });
  }
  const auto next = [&] { std::swap(scratch.from, scratch.to); };
  scratch.from.pad();
  if (rolls) {
    roll(o, course, frame, camera, shake, vibration, scratch.from, scratch.to);
    next();
    scratch.from.pad();
  } else if (shakes) {
    shift(shake, scratch.from, scratch.to);
    next();
    scratch.from.pad();
  }
  if (vibrates) {
    blur_along(vibration, scratch.from, scratch.to);
    next();
    scratch.from.pad();
  }
  if (o.defocus_px > 0.0) {
    defocus(o.defocus_px, scratch.from, scratch.to);
    next();
  }
  scratch.out.resize(clean.width, clean.height);
  for (int j = 0; j < clean.height; ++j) {
    const float* in = scratch.from.row(j);
    std::uint16_t* out = scratch.out.view().row(j);
    for (int i = 0; i < clean.width; ++i)
      out[i] = static_cast<std::uint16_t>(std::clamp(in[i] + 0.5F, 0.0F, static_cast<float>(kGreyMax)));
  }
  return scratch.out.cview();
}

}  // namespace cliquevo::drivers::sim
