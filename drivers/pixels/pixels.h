// SPDX-License-Identifier: BSD-3-Clause
// What cameras deliver, to grey images of 8 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/image.h"
#include "drivers/live/camera_options.h"

namespace cliquevo::drivers {

// A frame as it lies in memory.
struct RawFrame {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
  std::uint32_t fourcc = 0;  // V4L2_PIX_FMT_*
  int width = 0;
  int height = 0;
  std::size_t stride = 0;  // bytes from row to row; 0 = no gaps
};

// Whether frames of this format can be converted.
bool is_known_format(std::uint32_t fourcc);
// Whether it is a raw Bayer mosaic.
bool is_mosaic_format(std::uint32_t fourcc);
std::string fourcc_name(std::uint32_t fourcc);

// Width of one image in a frame of this width.
int image_width(CameraLayout layout, std::uint32_t fourcc, int width);

struct Conversion {
  bool whole = false;
  bool flawed = false;  // a JPEG of which the decoder warned, though every pixel is there
  explicit operator bool() const { return whole; }
};
// Grey values into `left` (and `right`, where one frame holds both images).
Conversion to_grey(const RawFrame& frame, CameraLayout layout, Image<std::uint8_t>& left, Image<std::uint8_t>& right);

}  // namespace cliquevo::drivers
