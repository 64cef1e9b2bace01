// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/decode_image.h"

#include <array>
#include <new>

#include <fmt/format.h>

#include "drivers/images/jpeg.h"

namespace cliquevo::drivers {

namespace {

constexpr std::array<ImageFormat, 5> kFormats{{
    {"PNG", is_png, decode_png},
    {"JPEG", is_jpeg, decode_jpeg_file},
    {"PGM or PPM", is_netpbm, decode_netpbm},
    {"TIFF", is_tiff, decode_tiff},
    {"BMP", is_bmp, decode_bmp},
}};

}  // namespace

std::span<const ImageFormat> image_formats() { return kFormats; }

std::string refuse_size(std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0) return "copy the recording again: its header gives it no size";
  if (width > kMostSidePx || height > kMostSidePx || width * height > kMostPixels) {
    return fmt::format("it is {}x{}: use images of at most {} px a side and {} million pixels", width, height,
                       kMostSidePx, kMostPixels / 1000000);
  }
  return {};
}

std::string decode_image(Bytes file, GreyPicture& picture) {
  picture.deep = false;
  picture.bits_in_use = 0;
  picture.warnings = 0;
  for (const ImageFormat& format : kFormats) {
    if (!format.recognises(file)) continue;
    try {
      return format.decode(file, picture);
    } catch (const std::bad_alloc&) {
      return "there is no memory for it: use smaller images";
    }
  }
  return "it is no PNG, JPEG, PGM, PPM, TIFF or BMP (torn, or of another kind): convert it to PNG";
}

bool is_jpeg(Bytes file) { return file.size() >= 3 && file[0] == 0xFF && file[1] == 0xD8 && file[2] == 0xFF; }

std::string decode_jpeg_file(Bytes file, GreyPicture& picture) {
  int width = 0;
  int height = 0;
  if (!read_jpeg_size(file.data(), file.size(), width, height)) return kTorn;
  if (std::string refused = refuse_size(width, height); !refused.empty()) return refused;
  // Brightness takes a bit at least for each block of 64 pixels.
  if (std::uint64_t{file.size()} * 8 * 64 < static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height)) {
    return kTorn;
  }
  picture.bytes.resize(width, height);
  const JpegResult result = decode_jpeg(file.data(), file.size(), picture.bytes.view());
  picture.warnings = result.warnings;
  return result.whole ? std::string() : kTorn;
}

}  // namespace cliquevo::drivers
