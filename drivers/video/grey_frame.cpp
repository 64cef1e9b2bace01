// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/video/grey_frame.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "drivers/images/grey_picture.h"

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
}

namespace cliquevo::drivers {

namespace {

// One component of the pixels, whatever its depth and place, as 8 bits.
class Component {
 public:
  Component(const AVFrame& frame, const AVPixFmtDescriptor& format, int which)
      : of_(format.comp[which]),
        data_(frame.data[of_.plane]),
        stride_(frame.linesize[of_.plane]),
        big_endian_((format.flags & AV_PIX_FMT_FLAG_BE) != 0) {}

  bool is_plain() const { return of_.depth == 8 && of_.step == 1 && of_.offset == 0; }
  const std::uint8_t* row(int y) const { return data_ + static_cast<std::ptrdiff_t>(y) * stride_; }
  std::uint8_t at(int x, int y) const {
    const std::uint8_t* p = row(y) + static_cast<std::ptrdiff_t>(x) * of_.step + of_.offset;
    if (of_.depth <= 8) return *p;
    const unsigned word =
        big_endian_ ? static_cast<unsigned>(p[0]) << 8U | p[1] : static_cast<unsigned>(p[1]) << 8U | p[0];
    const unsigned value = word >> static_cast<unsigned>(of_.shift);
    return static_cast<std::uint8_t>(std::min(255U, value >> static_cast<unsigned>(of_.depth - 8)));
  }

 private:
  const AVComponentDescriptor& of_;
  const std::uint8_t* data_;
  int stride_;
  bool big_endian_;
};

// 16 to 235 spread over 0 to 255, as video has its brightness unless it says otherwise.
std::array<std::uint8_t, 256> spread_range() {
  std::array<std::uint8_t, 256> out{};
  for (int i = 0; i < 256; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::clamp(((i - 16) * 255 + 109) / 219, 0, 255));
  return out;
}

bool has_full_range(const AVFrame& frame, const AVPixFmtDescriptor& format) {
  // Grey alone is of full range by libav's convention, whatever H.264 says by default.
  if (format.nb_components == 1 || frame.color_range == AVCOL_RANGE_JPEG) return true;
  return frame.color_range != AVCOL_RANGE_MPEG && std::strncmp(format.name, "yuvj", 4) == 0;
}

}  // namespace

bool grey_of_frame(const AVFrame& frame, Image<std::uint8_t>& out) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  constexpr std::uint64_t kUnreadable = AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL |
                                        AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BAYER;
  if (format == nullptr || (format->flags & kUnreadable) != 0 || format->comp[0].depth < 8) return false;
  out.resize(frame.width, frame.height);
  const ImageView<std::uint8_t> view = out.view();
  if ((format->flags & AV_PIX_FMT_FLAG_RGB) != 0) {
    const Component red(frame, *format, 0);
    const Component green(frame, *format, 1);
    const Component blue(frame, *format, 2);
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        view(x, y) = static_cast<std::uint8_t>(grey_of_rgb(red.at(x, y), green.at(x, y), blue.at(x, y)));
      }
    }
    return true;
  }
  const Component brightness(frame, *format, 0);
  for (int y = 0; y < view.height; ++y) {
    std::uint8_t* to = view.row(y);
    if (brightness.is_plain()) {
      std::memcpy(to, brightness.row(y), static_cast<std::size_t>(view.width));
    } else {
      for (int x = 0; x < view.width; ++x) to[x] = brightness.at(x, y);
    }
  }
  if (has_full_range(frame, *format)) return true;
  static const std::array<std::uint8_t, 256> kSpread = spread_range();
  for (int y = 0; y < view.height; ++y) {
    std::uint8_t* row = view.row(y);
    for (int x = 0; x < view.width; ++x) row[x] = kSpread[row[x]];
  }
  return true;
}

}  // namespace cliquevo::drivers
