// SPDX-License-Identifier: BSD-3-Clause
// What a rough camera does to the light before the sensor counts it: rolling shutter, a right camera that shakes on its
// mount, blur by vibration, defocus. Done to the noise-free picture of each frame; the truth stays that of a clean one.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "drivers/simulator.h"
#include "drivers/simulator/course.h"

namespace cliquevo::drivers::sim {

// How far the picture runs during the exposure of this frame, the same in both cameras.
struct Vibration {
  double x_px, y_px;
};
Vibration vibration_of(const SimulatorOptions& options, std::int64_t frame);

// Of the right camera against its place in this frame.
CameraShake shake_of(const SimulatorOptions& options, std::int64_t frame);

// Grey levels with a frame of repeated edge pixels around them, which may be read.
class PaddedPicture {
 public:
  static constexpr int kPad = 34;
  void resize(int width, int height);
  void pad();  // repeats the edges
  int width() const { return width_; }
  int height() const { return height_; }
  float* row(int j) { return data_.data() + static_cast<std::ptrdiff_t>(j + kPad) * stride_ + kPad; }
  const float* row(int j) const { return data_.data() + static_cast<std::ptrdiff_t>(j + kPad) * stride_ + kPad; }

 private:
  int width_ = 0, height_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<float> data_;
};

struct RoughScratch {
  PaddedPicture from, to;
  Image<std::uint16_t> out;
};

// The picture as this camera (0 left, 1 right) gets it; `clean` itself where the options roughen nothing.
ImageView<const std::uint16_t> roughen(const SimulatorOptions& options, const Course& course, std::int64_t frame,
                                       int camera, ImageView<const std::uint16_t> clean, RoughScratch& scratch);

}  // namespace cliquevo::drivers::sim
