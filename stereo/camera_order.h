// SPDX-License-Identifier: BSD-3-Clause
// Which image is the left camera's, by the images alone: points in front of a stereo pair lie further to the right in
// the left image. Exchanged images match the other way round, and the same picture twice matches without any shift.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/image.h"
#include "core/base/result.h"
#include "stereo/dense_stereo.h"

namespace cliquevo::stereo {

enum class CameraOrder {
  unknown,    // too little matches either way (far or bare scene, wrong calibration, too few frames yet)
  as_said,    // the left image is the left camera's
  exchanged,  // the left image is the right camera's
  same,       // both images are the same picture
};

// Of one pair.
struct OrderEvidence {
  double forward = 0.0;    // share of the image that matches as left and right
  double backward = 0.0;   // ... as right and left
  bool identical = false;  // are_identical()
};

// Works on images reduced to at most 256 px in width, a few of them; a pair costs some milliseconds.
class CameraOrderCheck {
 public:
  // Of images of this size; allocates everything.
  static Result<CameraOrderCheck> make(int width, int height);

  // Best on rectified images; a few rows of error do no harm. Images of another size, or a scene without contrast:
  // no evidence.
  OrderEvidence measure(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);
  // The first of these alone: as left and right.
  double measure_forward(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);
  // Adds the evidence; true: the pair changed order().
  bool add(const OrderEvidence& seen);
  CameraOrder order() const { return order_; }
  // Whether the pair with this running number (from 0) is worth a look: the first ones, later now and then for as long
  // as the order is unknown.
  bool wants(std::int64_t number) const;

 private:
  CameraOrderCheck(int width, int height, int factor, DenseStereo dense);
  void reduce(ImageView<const std::uint8_t> from, Image<std::uint8_t>& to) const;
  double matched_share(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);
  CameraOrder judge() const;

  int width_;
  int height_;
  int factor_;
  DenseStereo dense_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  Image<std::uint8_t> moved_;
  Image<std::uint8_t> filtered_;
  Image<std::int16_t> disparity_;
  int pairs_ = 0;
  int identical_ = 0;
  double forward_ = 0.0;
  double backward_ = 0.0;
  CameraOrder order_ = CameraOrder::unknown;
};

// Whether two images are the same picture, but for what a second compression does to it. For images as grabbed:
// rectification turns each camera its own way.
bool are_identical(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);

// One sentence on what to do; empty for `unknown` and `as_said`.
std::string describe(CameraOrder order);

}  // namespace cliquevo::stereo
