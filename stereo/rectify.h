// SPDX-License-Identifier: BSD-3-Clause
// Rectification: raw pair -> pair whose rows are epipolar lines.
#pragma once

#include <memory>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "stereo/rectify_params.h"

namespace cliquevo::stereo {

// Which camera of the pair.
enum class CameraSide { left, right };

// From images as grabbed to images whose rows are epipolar lines.
class Rectifier {
 public:
  // Where the calibration prescribes a rectification (R_rect, P_rect) that one is used; otherwise one is computed
  // (Fusiello-style: equal turn of both cameras, pixels kept at about their size, no black borders on level pairs).
  // params: another size or field of view. Where the rectified pixels are at least twice the raw ones', means of 2x2
  // (4x4 ...) raw pixels are what is resampled, so that fine texture does not alias. Images that are rectified already
  // are resampled likewise.
  // Fails on a calibration that cannot be (singular, negative, not finite, cameras that do not look the same way).
  static Result<Rectifier> make(const StereoCalibration& calibration, const RectifyParams& params = {});

  Rectifier(Rectifier&&) noexcept;
  Rectifier& operator=(Rectifier&&) noexcept;
  ~Rectifier();

  // The rectified pair; its width and height are those of the images rectify() writes.
  const StereoModel& model() const;
  // True when the input already is rectified: rectify() then copies.
  bool is_identity() const;
  // raw: calibration's size; out: model's size. Pixels without a source become 0. No allocation. One thread at a time.
  Result<void> rectify(CameraSide side, ImageView<const std::uint8_t> raw, ImageView<std::uint8_t> out) const;
  // The same for a 0/255 mask, nearest neighbour; pixels without a source become 0 (= not to be used).
  Result<void> rectify_mask(CameraSide side, ImageView<const std::uint8_t> raw, ImageView<std::uint8_t> out) const;

 private:
  struct Impl;
  explicit Rectifier(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::stereo
