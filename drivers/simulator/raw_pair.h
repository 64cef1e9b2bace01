// SPDX-License-Identifier: BSD-3-Clause
// The pair as grabbed: cameras that are slightly turned against each other and lenses that distort.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

// The rectified pair of the options: true poses and disparities are for it, whether the images are raw or not.
StereoModel rectified_model(const SimulatorOptions& options);

// What SourceInfo holds. Raw: plumb-bob lenses, both cameras turned by the same angle in opposite ways (so that every
// usual rectification turns them back to the same orientation), and that rectification as the prescribed one.
StereoCalibration simulated_calibration(const SimulatorOptions& options);

// How one raw image comes about: a pinhole image of twice the resolution in the raw camera's orientation, resampled
// through the lens. Its pixels' aperture and the resampling's kernel are symmetric, so that nothing is shifted.
class RawCamera {
 public:
  explicit RawCamera(const CameraCalibration& camera);

  // The pinhole image wanted.
  int width() const { return width_; }
  int height() const { return height_; }
  double focal_px() const { return focal_px_; }
  double cx_px() const { return cx_px_; }
  double cy_px() const { return cy_px_; }

  // pinhole: width() x height(), rows without gaps. Grey levels of the raw image, times `scale`, at most `limit`.
  void resample(const std::vector<float>& pinhole, float scale, float limit, Image<std::uint16_t>& raw) const;

 private:
  static constexpr int kTaps = 5;
  static constexpr int kFractions = 1024;
  struct Source {
    std::int32_t start;   // first pixel of the 5 x 5
    std::int16_t fx, fy;  // which weights
  };

  int raw_width_, raw_height_;
  int width_ = 0, height_ = 0;
  double focal_px_ = 0.0, cx_px_ = 0.0, cy_px_ = 0.0;
  std::vector<Source> map_;
};

}  // namespace cliquevo::drivers::sim
