// SPDX-License-Identifier: BSD-3-Clause
// Images as browsers take them: JPEG, and disparity as an 8-bit PNG.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "core/vo/seen_feature.h"

namespace cliquevo::view {

using Bytes = std::vector<unsigned char>;

inline constexpr int kJpegQuality = 82;  // of the page's pictures
inline constexpr int kMaskQuality = 95;

// Keeps libjpeg's memory between pictures.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;
  // quality: 1 to 100. Empty when the picture is, or cannot be encoded.
  Bytes encode(ImageView<const std::uint8_t> grey, int quality);

 private:
  struct Impl;
  Impl* impl_;
};

// Grey levels 1 to 255 are disparities of level * step px; 0 = unknown, or not above 0.
struct DisparityPicture {
  Bytes png;
  float step_px = 0.25F;
};
DisparityPicture encode_disparity(ImageView<const std::int16_t> disparity);

// As it goes to the page: six floats and the role in 32 bits each.
Bytes pack_features(const std::vector<vo::SeenFeature>& features);

// Every other pixel and row (or every nth), for thumbnails: means of the squares.
Image<std::uint8_t> shrunk(ImageView<const std::uint8_t> grey, int width);

}  // namespace cliquevo::view
