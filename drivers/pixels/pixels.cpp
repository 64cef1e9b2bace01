// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/pixels/pixels.h"

#include <array>
#include <linux/videodev2.h>
#include <optional>

#include "drivers/images/bayer.h"
#include "drivers/images/jpeg.h"
#include "drivers/images/packed_samples.h"

namespace cliquevo::drivers {

namespace {

constexpr std::uint32_t kY8I = v4l2_fourcc('Y', '8', 'I', ' ');

// Where the grey value of a pixel is.
struct Packing {
  std::size_t bytes = 1;   // a pixel
  std::size_t offset = 0;  // of its grey byte (the low one of two)
  int shift = -1;          // >= 0: sixteen bits, little-endian, to be shifted so far
};

// Raw Bayer mosaics: bits a sample, whether they share bytes, and the formats' names in the four patterns.
struct MosaicFormats {
  Packing packing;
  std::optional<PackedSamples> packed;
  std::array<std::uint32_t, 4> formats;
};
constexpr std::uint32_t kY12P = v4l2_fourcc('Y', '1', '2', 'P');  // newer than some kernels' headers
constexpr std::array<MosaicFormats, 6> kMosaics{{
    {{1, 0, -1}, {}, {V4L2_PIX_FMT_SBGGR8, V4L2_PIX_FMT_SGBRG8, V4L2_PIX_FMT_SGRBG8, V4L2_PIX_FMT_SRGGB8}},
    {{2, 0, 2}, {}, {V4L2_PIX_FMT_SBGGR10, V4L2_PIX_FMT_SGBRG10, V4L2_PIX_FMT_SGRBG10, V4L2_PIX_FMT_SRGGB10}},
    {{2, 0, 4}, {}, {V4L2_PIX_FMT_SBGGR12, V4L2_PIX_FMT_SGBRG12, V4L2_PIX_FMT_SGRBG12, V4L2_PIX_FMT_SRGGB12}},
    {{2, 0, 8}, {}, {V4L2_PIX_FMT_SBGGR16, V4L2_PIX_FMT_SGBRG16, V4L2_PIX_FMT_SGRBG16, V4L2_PIX_FMT_SRGGB16}},
    {{},
     PackedSamples::mipi_10,
     {V4L2_PIX_FMT_SBGGR10P, V4L2_PIX_FMT_SGBRG10P, V4L2_PIX_FMT_SGRBG10P, V4L2_PIX_FMT_SRGGB10P}},
    {{},
     PackedSamples::mipi_12,
     {V4L2_PIX_FMT_SBGGR12P, V4L2_PIX_FMT_SGBRG12P, V4L2_PIX_FMT_SGRBG12P, V4L2_PIX_FMT_SRGGB12P}},
}};

const MosaicFormats* mosaic_of(std::uint32_t fourcc) {
  for (const MosaicFormats& row : kMosaics) {
    for (const std::uint32_t format : row.formats) {
      if (format == fourcc) return &row;
    }
  }
  return nullptr;
}

std::optional<PackedSamples> packed_of(std::uint32_t fourcc) {
  if (fourcc == V4L2_PIX_FMT_Y10P) return PackedSamples::mipi_10;
  if (fourcc == kY12P) return PackedSamples::mipi_12;
  if (fourcc == V4L2_PIX_FMT_Y10BPACK) return PackedSamples::big_endian_10;
  const MosaicFormats* mosaic = mosaic_of(fourcc);
  return mosaic != nullptr ? mosaic->packed : std::nullopt;
}

bool packing_of(std::uint32_t fourcc, Packing& out) {
  if (const MosaicFormats* mosaic = mosaic_of(fourcc); mosaic != nullptr && !mosaic->packed) {
    out = mosaic->packing;
    return true;
  }
  switch (fourcc) {
    case V4L2_PIX_FMT_GREY:
      out = {1, 0, -1};
      return true;
    case V4L2_PIX_FMT_Y10:
      out = {2, 0, 2};
      return true;
    case V4L2_PIX_FMT_Y12:
      out = {2, 0, 4};
      return true;
    case V4L2_PIX_FMT_Y14:
      out = {2, 0, 6};
      return true;
    case V4L2_PIX_FMT_Y16:
      out = {2, 0, 8};
      return true;
    case V4L2_PIX_FMT_YUYV:
    case kY8I:
      out = {2, 0, -1};
      return true;
    case V4L2_PIX_FMT_UYVY:
      out = {2, 1, -1};
      return true;
    case V4L2_PIX_FMT_NV12:
    case V4L2_PIX_FMT_YUV420:
      out = {1, 0, -1};  // the grey plane comes first
      return true;
    default:
      return false;
  }
}

bool is_jpeg(std::uint32_t fourcc) { return fourcc == V4L2_PIX_FMT_MJPEG || fourcc == V4L2_PIX_FMT_JPEG; }

// Interleaved images in pixels of two bytes are a byte each; in pixels of one byte they are every second pixel.
bool byte_by_byte(std::uint32_t fourcc) { return fourcc == kY8I || fourcc == V4L2_PIX_FMT_YUYV; }

std::uint8_t grey_of(const std::uint8_t* pixel, const Packing& packing) {
  if (packing.shift < 0) return pixel[packing.offset];
  const unsigned value = static_cast<unsigned>(pixel[0]) | static_cast<unsigned>(pixel[1]) << 8U;
  const unsigned grey = value >> static_cast<unsigned>(packing.shift);
  return static_cast<std::uint8_t>(grey > 255U ? 255U : grey);
}

// From packed pixels; `pitch`: pixels (or bytes) from one of the image's to the next.
void take_side(const RawFrame& frame, const Packing& packing, std::size_t first, std::size_t pitch,
               Image<std::uint8_t>& image) {
  const std::size_t stride = frame.stride != 0 ? frame.stride : packing.bytes * static_cast<std::size_t>(frame.width);
  for (int y = 0; y < image.height(); ++y) {
    const std::uint8_t* from = frame.data + stride * static_cast<std::size_t>(y) + first;
    std::uint8_t* to = image.view().row(y);
    for (int x = 0; x < image.width(); ++x) to[x] = grey_of(from + pitch * static_cast<std::size_t>(x), packing);
  }
}

// Pixels of whole bytes, to one image or two.
bool split(const RawFrame& frame, CameraLayout layout, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
  const int width = left.width();
  Packing packing;
  if (!packing_of(frame.fourcc, packing)) return false;
  const std::size_t row = packing.bytes * static_cast<std::size_t>(frame.width);
  const std::size_t stride = frame.stride != 0 ? frame.stride : row;
  if (stride < row || frame.size < stride * static_cast<std::size_t>(frame.height - 1) + row) return false;
  switch (layout) {
    case CameraLayout::two_cameras:
      take_side(frame, packing, 0, packing.bytes, left);
      break;
    case CameraLayout::side_by_side:
      take_side(frame, packing, 0, packing.bytes, left);
      take_side(frame, packing, packing.bytes * static_cast<std::size_t>(width), packing.bytes, right);
      break;
    case CameraLayout::interleaved:
      if (byte_by_byte(frame.fourcc)) {
        const Packing bytes{1, 0, -1};
        RawFrame whole = frame;
        whole.stride = stride;
        take_side(whole, bytes, 0, 2, left);
        take_side(whole, bytes, 1, 2, right);
      } else {
        take_side(frame, packing, 0, 2 * packing.bytes, left);
        take_side(frame, packing, packing.bytes, 2 * packing.bytes, right);
      }
      break;
  }
  return true;
}

// What is not pixel by pixel in memory, as a whole frame.
Conversion unpack(const RawFrame& frame, ImageView<std::uint8_t> out) {
  if (const auto packed = packed_of(frame.fourcc)) {
    return {unpack_samples(*packed, frame.data, frame.size, frame.stride, out), false};
  }
  const JpegResult jpeg = decode_jpeg(frame.data, frame.size, out);
  return {jpeg.whole, jpeg.warnings > 0};
}

RawFrame as_grey(const Image<std::uint8_t>& image) {
  const auto stride = static_cast<std::size_t>(image.cview().stride);
  return {image.cview().data, stride * static_cast<std::size_t>(image.height()),
          V4L2_PIX_FMT_GREY,  image.width(),
          image.height(),     stride};
}

}  // namespace

bool is_known_format(std::uint32_t fourcc) {
  Packing packing;
  return is_jpeg(fourcc) || packed_of(fourcc) || packing_of(fourcc, packing);
}

bool is_mosaic_format(std::uint32_t fourcc) { return mosaic_of(fourcc) != nullptr; }

std::string fourcc_name(std::uint32_t fourcc) {
  std::string out;
  for (unsigned i = 0; i < 4; ++i) {
    const char c = static_cast<char>(fourcc >> (8 * i) & 0x7fU);
    if (c > ' ') out += c;
  }
  return out;
}

int image_width(CameraLayout layout, std::uint32_t fourcc, int width) {
  if (layout == CameraLayout::two_cameras) return width;
  return layout == CameraLayout::interleaved && byte_by_byte(fourcc) ? width : width / 2;
}

Conversion to_grey(const RawFrame& frame, CameraLayout layout, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
  const int width = image_width(layout, frame.fourcc, frame.width);
  left.resize(width, frame.height);
  if (layout != CameraLayout::two_cameras) right.resize(width, frame.height);
  Conversion out;
  if (is_jpeg(frame.fourcc) || packed_of(frame.fourcc)) {
    if (layout == CameraLayout::two_cameras) {
      out = unpack(frame, left.view());
    } else {
      Image<std::uint8_t> both(frame.width, frame.height);
      out = unpack(frame, both.view());
      out.whole = out.whole && split(as_grey(both), layout, left, right);
    }
  } else {
    out.whole = split(frame, layout, left, right);
  }
  if (out.whole && is_mosaic_format(frame.fourcc)) {
    MosaicToGrey to_grey_image;
    to_grey_image.convert(left.view());
    if (layout != CameraLayout::two_cameras) to_grey_image.convert(right.view());
  }
  return out;
}

}  // namespace cliquevo::drivers
