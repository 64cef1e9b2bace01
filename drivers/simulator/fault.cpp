// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/fault.h"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr float kCoveredGrey = 9.0F;

// Every pixel through f(x, y, grey), clamped to 8 bits.
template <typename F>
void for_each(Image<std::uint8_t>& image, F&& f) {
  for (int y = 0; y < image.height(); ++y) {
    std::uint8_t* row = image.view().row(y);
    for (int x = 0; x < image.width(); ++x)
      row[x] = static_cast<std::uint8_t>(std::clamp(f(x, y, static_cast<float>(row[x])) + 0.5F, 0.0F, 255.0F));
  }
}

}  // namespace

bool fault_active(const SimulatorOptions& o, std::int64_t frame) {
  if (o.fault == "none" || frame < o.fault_first) return false;
  return o.fault_frames < 0 || frame < o.fault_first + o.fault_frames;
}

std::int64_t delivered_frame(const SimulatorOptions& o, std::int64_t frame, int side) {
  if (side == 0 || o.fault != "frozen" || !fault_active(o, frame)) return frame;
  return std::max<std::int64_t>(o.fault_first - 1, 0);
}

double fault_gain(const SimulatorOptions& o, std::int64_t frame) {
  return o.fault == "night" && fault_active(o, frame) ? 0.05 : 1.0;
}

void apply_fault(const SimulatorOptions& o, std::int64_t frame, int side, Image<std::uint8_t>& image) {
  if (!fault_active(o, frame)) return;
  const auto width = static_cast<float>(image.width());
  const auto height = static_cast<float>(image.height());
  if (o.fault == "blank") {
    image.fill(128);
  } else if (o.fault == "noise") {
    Random random(hash_cell(mix64(o.noise_seed ^ 0x736e6f77ULL), frame, side));
    for_each(image, [&](int, int, float) { return static_cast<float>(random.bits() & 255U); });
  } else if (o.fault == "covered" && side == 0) {
    // Something over the left lens, out of focus: all but the upper right corner.
    for_each(image, [&](int x, int y, float grey) {
      const float edge = (static_cast<float>(x) / width - 0.72F) - (static_cast<float>(y) / height - 0.20F);
      const float open = std::clamp(edge / 0.12F + 0.5F, 0.0F, 1.0F);
      return kCoveredGrey + open * (grey - kCoveredGrey);
    });
  } else if (o.fault == "flare") {
    // The sun beside the image: a glow that wanders, a veil over everything, and ghosts; they stay with the lens.
    const auto t = static_cast<float>(static_cast<double>(frame) / o.rate_hz);
    const float sun_x = width * (0.35F + 0.10F * std::sin(0.9F * t) + 0.01F * static_cast<float>(side));
    const float sun_y = height * (0.05F + 0.04F * std::sin(1.7F * t));
    for_each(image, [&](int x, int y, float grey) {
      const float dx = static_cast<float>(x) - sun_x;
      const float dy = static_cast<float>(y) - sun_y;
      const float r = std::sqrt(dx * dx + dy * dy) / width;
      const float gx = static_cast<float>(x) - (width - sun_x);
      const float gy = static_cast<float>(y) - (height - sun_y);
      const float ghost = std::sqrt(gx * gx + gy * gy) / width < 0.08F ? 40.0F : 0.0F;
      return 0.75F * grey + 30.0F + 420.0F * std::exp(-r * 9.0F) + ghost;
    });
  }
}

}  // namespace cliquevo::drivers::sim
