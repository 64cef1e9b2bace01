// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/v4l2/pixels.h"

#include <csetjmp>
#include <cstdio>
#include <jpeglib.h>
#include <linux/videodev2.h>

namespace cliquevo::drivers {

namespace {

constexpr std::uint32_t kY8I = v4l2_fourcc('Y', '8', 'I', ' ');

// Where the grey value of a pixel is.
struct Packing {
  std::size_t bytes = 1;   // a pixel
  std::size_t offset = 0;  // of its grey byte (the low one of two)
  int shift = -1;          // >= 0: sixteen bits, little-endian, to be shifted so far
};

bool packing_of(std::uint32_t fourcc, Packing& out) {
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

// Interleaved eyes in pixels of two bytes are a byte each; in pixels of one byte they are every second pixel.
bool byte_by_byte(std::uint32_t fourcc) { return fourcc == kY8I || fourcc == V4L2_PIX_FMT_YUYV; }

std::uint8_t grey_of(const std::uint8_t* pixel, const Packing& packing) {
  if (packing.shift < 0) return pixel[packing.offset];
  const unsigned value = static_cast<unsigned>(pixel[0]) | static_cast<unsigned>(pixel[1]) << 8U;
  const unsigned grey = value >> static_cast<unsigned>(packing.shift);
  return static_cast<std::uint8_t>(grey > 255U ? 255U : grey);
}

struct JpegFailure {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

// Whole pictures alone: a decoder that fills in what is missing has warned of it.
bool decode_jpeg(const std::uint8_t* data, std::size_t size, int width, int height, std::uint8_t* out,
                 std::size_t stride) {
  jpeg_decompress_struct jpeg;
  JpegFailure failure;
  jpeg.err = jpeg_std_error(&failure.manager);
  failure.manager.error_exit = [](j_common_ptr info) {
    std::longjmp(reinterpret_cast<JpegFailure*>(info->err)->back, 1);
  };
  failure.manager.output_message = [](j_common_ptr) {};
  if (setjmp(failure.back) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, data, size);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  const bool fits = static_cast<int>(jpeg.output_width) == width && static_cast<int>(jpeg.output_height) == height;
  while (fits && jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = out + stride * jpeg.output_scanline;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  if (fits) jpeg_finish_decompress(&jpeg);
  const bool whole = fits && failure.manager.num_warnings == 0;
  jpeg_destroy_decompress(&jpeg);
  return whole;
}

// From packed pixels; `pitch`: pixels (or bytes) from one of the eye's to the next.
void take_eye(const RawFrame& frame, const Packing& packing, std::size_t first, std::size_t pitch,
              Image<std::uint8_t>& eye) {
  const std::size_t stride = frame.stride != 0 ? frame.stride : packing.bytes * static_cast<std::size_t>(frame.width);
  for (int y = 0; y < eye.height(); ++y) {
    const std::uint8_t* from = frame.data + stride * static_cast<std::size_t>(y) + first;
    std::uint8_t* to = eye.view().row(y);
    for (int x = 0; x < eye.width(); ++x) to[x] = grey_of(from + pitch * static_cast<std::size_t>(x), packing);
  }
}

}  // namespace

bool is_known_format(std::uint32_t fourcc) {
  Packing packing;
  return is_jpeg(fourcc) || packing_of(fourcc, packing);
}

std::string fourcc_name(std::uint32_t fourcc) {
  std::string out;
  for (unsigned i = 0; i < 4; ++i) {
    const char c = static_cast<char>(fourcc >> (8 * i) & 0x7fU);
    if (c > ' ') out += c;
  }
  return out;
}

int eye_width(EyeLayout layout, std::uint32_t fourcc, int width) {
  if (layout == EyeLayout::two_cameras) return width;
  return layout == EyeLayout::interleaved && byte_by_byte(fourcc) ? width : width / 2;
}

bool to_grey(const RawFrame& frame, EyeLayout layout, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
  const int width = eye_width(layout, frame.fourcc, frame.width);
  left.resize(width, frame.height);
  if (layout != EyeLayout::two_cameras) right.resize(width, frame.height);
  if (is_jpeg(frame.fourcc)) {
    if (layout == EyeLayout::two_cameras) {
      return decode_jpeg(frame.data, frame.size, frame.width, frame.height, left.view().data,
                         static_cast<std::size_t>(left.view().stride));
    }
    Image<std::uint8_t> both(frame.width, frame.height);
    const auto stride = static_cast<std::size_t>(both.view().stride);
    if (!decode_jpeg(frame.data, frame.size, frame.width, frame.height, both.view().data, stride)) return false;
    const RawFrame grey{both.view().data,  stride * static_cast<std::size_t>(frame.height),
                        V4L2_PIX_FMT_GREY, frame.width,
                        frame.height,      stride};
    return to_grey(grey, layout, left, right);
  }
  Packing packing;
  if (!packing_of(frame.fourcc, packing)) return false;
  const std::size_t row = packing.bytes * static_cast<std::size_t>(frame.width);
  const std::size_t stride = frame.stride != 0 ? frame.stride : row;
  if (stride < row || frame.size < stride * static_cast<std::size_t>(frame.height - 1) + row) return false;
  switch (layout) {
    case EyeLayout::two_cameras:
      take_eye(frame, packing, 0, packing.bytes, left);
      break;
    case EyeLayout::side_by_side:
      take_eye(frame, packing, 0, packing.bytes, left);
      take_eye(frame, packing, packing.bytes * static_cast<std::size_t>(width), packing.bytes, right);
      break;
    case EyeLayout::interleaved:
      if (byte_by_byte(frame.fourcc)) {
        const Packing bytes{1, 0, -1};
        RawFrame whole = frame;
        whole.stride = stride;
        take_eye(whole, bytes, 0, 2, left);
        take_eye(whole, bytes, 1, 2, right);
      } else {
        take_eye(frame, packing, 0, 2 * packing.bytes, left);
        take_eye(frame, packing, packing.bytes, 2 * packing.bytes, right);
      }
      break;
  }
  return true;
}

}  // namespace cliquevo::drivers
