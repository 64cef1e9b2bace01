// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "drivers/simulator/fault.h"
#include "drivers/simulator/hash.h"
#include "drivers/simulator/renderer.h"

namespace cliquevo::drivers::sim {

namespace {

// Electrons of a saturated pixel; a small machine-vision sensor.
constexpr double kFullWell = 10000.0;
constexpr int kNormalBits = 14;
constexpr float kMiddleGrey = 110.0F;  // what hard sun leaves as it is

// Standard normal deviates at the midpoints of 2^14 equal probabilities (bisection of the error function would do;
// Newton on it is quicker). A draw is a lookup.
std::vector<float> normal_table() {
  constexpr int n = 1 << kNormalBits;
  std::vector<float> table(n);
  double x = 0.0;
  for (int i = n / 2; i < n; ++i) {
    const double p = (i + 0.5) / n;
    for (int k = 0; k < 30; ++k) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
      const double error = 0.5 * std::erfc(-x / std::numbers::sqrt2) - p;
      const double step = error / density;
      x -= step;
      if (std::abs(step) < 1e-12) break;
    }
    table[static_cast<std::size_t>(i)] = static_cast<float>(x);
    table[static_cast<std::size_t>(n - 1 - i)] = static_cast<float>(-x);
  }
  return table;
}

// How the right camera answers beside the left one: 255 gain (v / 255)^gamma + bias, in steps of a quarter grey level.
class Response {
 public:
  Response(const SimulatorOptions& o, int side)
      : on_(side == 1 && (o.right_gain != 1.0 || o.right_gamma != 1.0 || o.right_bias != 0.0)) {
    if (!on_) return;
    for (std::size_t i = 0; i < table_.size(); ++i) {
      const double light = static_cast<double>(i) / (4.0 * 255.0);
      table_[i] = static_cast<float>(255.0 * o.right_gain * std::pow(light, o.right_gamma) + o.right_bias);
    }
  }
  float operator()(float v) const {
    if (!on_) return v;
    const float at = std::clamp(v, 0.0F, 255.0F) * 4.0F;
    const auto i = std::min(static_cast<std::size_t>(at), table_.size() - 2);
    return table_[i] + (at - static_cast<float>(i)) * (table_[i + 1] - table_[i]);
  }

 private:
  bool on_;
  std::array<float, 1021> table_{};
};

}  // namespace

double exposure_gain(const SimulatorOptions& o, std::int64_t frame) {
  if (!o.exposure_changes) return 1.0;
  const double t = static_cast<double>(frame) / o.rate_hz;
  const double drift =
      0.05 * std::sin(2.0 * std::numbers::pi * t / 11.0) + 0.03 * std::sin(2.0 * std::numbers::pi * t / 4.3 + 1.0);
  // Every 1.7 s the automatic exposure may choose anew; it gets there in 0.1 s.
  constexpr double kPeriodS = 1.7;
  const auto target = [&](std::int64_t k) {
    return k < 0 ? 0.0 : 0.12 * (2.0 * to_unit(hash_cell(o.world_seed ^ 0xae, k, 0)) - 1.0);
  };
  const auto k = static_cast<std::int64_t>(std::floor(t / kPeriodS));
  const double since = t - static_cast<double>(k) * kPeriodS;
  const double done = std::clamp(since / 0.1, 0.0, 1.0);
  return std::exp(drift + target(k - 1) + done * (target(k) - target(k - 1)));
}

void expose(const SimulatorOptions& o, std::int64_t frame, int side, ImageView<const std::uint16_t> clean,
            Image<std::uint8_t>& out) {
  static const std::vector<float> kNormal = normal_table();
  out.resize(clean.width, clean.height);
  const auto gain = static_cast<float>(exposure_gain(o, frame) * fault_gain(o, frame) / kGreyScale);
  // Deviation by grey level, in steps of 1/4.
  std::array<float, 1025> deviation{};
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    const double shot = o.shot_noise ? 0.25 * static_cast<double>(i) * 255.0 / kFullWell : 0.0;
    deviation[i] = static_cast<float>(std::sqrt(o.noise_sigma * o.noise_sigma + shot));
  }
  const auto contrast = static_cast<float>(o.sun_contrast);
  const bool hard_sun = o.sun_contrast >= 0.0 && o.sun_contrast != 1.0;
  const Response response(o, side);
  const bool noisy = o.noise_sigma > 0.0 || o.shot_noise;
  const std::uint64_t image_seed = hash_cell(mix64(o.noise_seed ^ 0x6e6f697365ULL), frame, side);
  for (int j = 0; j < clean.height; ++j) {
    const std::uint16_t* in = clean.row(j);
    std::uint8_t* row = out.view().row(j);
    const std::uint64_t row_seed = mix64(image_seed + static_cast<std::uint64_t>(j) * 0x9e3779b97f4a7c15ULL);
    std::uint64_t bits = 0;
    for (int i = 0; i < clean.width; ++i) {
      float v = std::min(static_cast<float>(in[i]) * gain, 255.0F);
      if (hard_sun) v = std::clamp(kMiddleGrey + contrast * (v - kMiddleGrey), 0.0F, 255.0F);
      float noise = 0.0F;
      if (noisy) {
        if ((i & 3) == 0) bits = mix64(row_seed + static_cast<std::uint64_t>(i));
        noise = kNormal[bits & ((1U << kNormalBits) - 1U)] * deviation[static_cast<std::size_t>(v * 4.0F)];
        bits >>= 16;
      }
      row[i] = static_cast<std::uint8_t>(std::clamp(response(v + noise) + 0.5F, 0.0F, 255.0F));
    }
  }
}

}  // namespace cliquevo::drivers::sim
