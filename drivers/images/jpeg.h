// SPDX-License-Identifier: BSD-3-Clause
// JPEG to grey, for files and for cameras that send motion JPEG.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/image.h"

namespace cliquevo::drivers {

struct JpegResult {
  bool whole = false;  // every pixel was decoded from data
  int warnings = 0;    // bytes too many, no end marker, ...: what libjpeg warned of
};

// The size in the header; false: there is none.
bool read_jpeg_size(const std::uint8_t* data, std::size_t size, int& width, int& height);

// Into `out`, which has the image's size (else it is not whole). Bytes too many before markers or behind the end, and a
// missing end marker are warnings; missing or damaged data, which libjpeg would fill in with grey, is not whole.
JpegResult decode_jpeg(const std::uint8_t* data, std::size_t size, ImageView<std::uint8_t> out);

}  // namespace cliquevo::drivers
