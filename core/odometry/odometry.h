// SPDX-License-Identifier: BSD-3-Clause
// From images to poses in one call: rectification, dense stereo and visual odometry one after the other, on the
// caller's thread. The result is that of `cliquevo replay` on the same images, byte for byte.
#pragma once

#include <memory>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/time.h"
#include "core/odometry/odometry_params.h"
#include "core/vo/visual_odometry.h"

namespace cliquevo {

// Rectification, dense stereo and visual odometry of one stereo camera.
class Odometry {
 public:
  // For images that are rectified already: rows are epipolar lines.
  static Result<Odometry> make(const StereoModel& model, const OdometryParams& params = {},
                               const OdometryMasks& masks = {});
  // For images as the calibration describes them: as grabbed, or rectified where it has that flag.
  static Result<Odometry> make(const StereoCalibration& calibration, const OdometryParams& params = {},
                               const OdometryMasks& masks = {});
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;
  ~Odometry();

  // One pair of 8-bit grey images of the calibration's size, in order of exposure; rows may be any stride >= width
  // apart. The views are read during the call only, and not copied where the images are rectified already. An Error
  // means unusable input (a missing or wrongly sized image, a stamp that does not advance): the state is as before the
  // call. Everything else is a status in the estimate. No allocation after the first frames. One thread at a time.
  Result<vo::Estimate> step(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                            TimestampNs stamp_ns);

  // The last step's; the defaults before the first one.
  const vo::Estimate& estimate() const;
  // What else moved in the last frame.
  const vo::Movers& movers() const;
  // What became of the last frame's features.
  void list_features(std::vector<vo::SeenFeature>& out) const;
  // Of the last frame, rectified size: px * kDisparityScale, kUnknownDisparity where unknown. Valid until the next
  // step.
  ImageView<const std::int16_t> disparity() const;

  // The rectified pair that poses refer to.
  const StereoModel& model() const;
  // Size of the images that step() takes: of the left and the right camera.
  int left_width() const;
  int left_height() const;   // px
  int right_width() const;   // px
  int right_height() const;  // px
  // Forgets all frames and starts again at the identity.
  void reset();

 private:
  struct Impl;
  explicit Odometry(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo
