// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/ros_images.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cliquevo::drivers {

namespace {

// How the pixels of an encoding lie in memory.
struct Encoding {
  std::string_view name;
  int channels = 1;  // samples a pixel in memory
  int bytes = 1;     // a sample
  int red = 0;       // where red, green and blue are; of one channel and of YUV: where the grey is, with green -1
  int green = -1;
  int blue = -1;
  bool mosaic = false;
};

constexpr std::array kEncodings{
    Encoding{"mono8"},
    Encoding{"8UC1"},
    Encoding{"mono16", 1, 2},
    Encoding{"16UC1", 1, 2},
    Encoding{"rgb8", 3, 1, 0, 1, 2},
    Encoding{"bgr8", 3, 1, 2, 1, 0},
    Encoding{"8UC3", 3, 1, 2, 1, 0},
    Encoding{"rgba8", 4, 1, 0, 1, 2},
    Encoding{"bgra8", 4, 1, 2, 1, 0},
    Encoding{"8UC4", 4, 1, 2, 1, 0},
    Encoding{"rgb16", 3, 2, 0, 1, 2},
    Encoding{"bgr16", 3, 2, 2, 1, 0},
    Encoding{"rgba16", 4, 2, 0, 1, 2},
    Encoding{"bgra16", 4, 2, 2, 1, 0},
    // Two bytes a pixel, one of them its brightness.
    Encoding{"yuv422", 2, 1, 1},
    Encoding{"uyvy", 2, 1, 1},
    Encoding{"yuv422_yuy2", 2, 1, 0},
    Encoding{"yuyv", 2, 1, 0},
    // Their first plane is the brightness.
    Encoding{"nv12"},
    Encoding{"nv21"},
    Encoding{"nv24"},
    Encoding{"bayer_rggb8", 1, 1, 0, -1, -1, true},
    Encoding{"bayer_bggr8", 1, 1, 0, -1, -1, true},
    Encoding{"bayer_gbrg8", 1, 1, 0, -1, -1, true},
    Encoding{"bayer_grbg8", 1, 1, 0, -1, -1, true},
    Encoding{"bayer_rggb16", 1, 2, 0, -1, -1, true},
    Encoding{"bayer_bggr16", 1, 2, 0, -1, -1, true},
    Encoding{"bayer_gbrg16", 1, 2, 0, -1, -1, true},
    Encoding{"bayer_grbg16", 1, 2, 0, -1, -1, true},
};

const Encoding* encoding_named(std::string_view name) {
  const auto found =
      std::find_if(kEncodings.begin(), kEncodings.end(), [&](const Encoding& e) { return e.name == name; });
  return found == kEncodings.end() ? nullptr : &*found;
}

struct Sampler {
  const Encoding& encoding;
  bool big_endian = false;

  unsigned sample(const std::uint8_t* pixel, int which) const {
    if (encoding.bytes == 1) return pixel[which];
    const std::uint8_t* at = pixel + 2 * which;
    return big_endian ? static_cast<unsigned>(at[0]) << 8U | at[1] : static_cast<unsigned>(at[1]) << 8U | at[0];
  }
  unsigned grey(const std::uint8_t* pixel) const {
    if (encoding.green < 0) return sample(pixel, encoding.red);
    return grey_of_rgb(sample(pixel, encoding.red), sample(pixel, encoding.green), sample(pixel, encoding.blue));
  }
};

template <typename T>
void convert(const RosImage& image, const Sampler& sampler, Image<T>& out) {
  out.resize(static_cast<int>(image.width), static_cast<int>(image.height));
  const auto stride =
      static_cast<std::size_t>(sampler.encoding.channels) * static_cast<std::size_t>(sampler.encoding.bytes);
  for (int y = 0; y < out.height(); ++y) {
    const std::uint8_t* from = image.data.data() + static_cast<std::size_t>(y) * image.step;
    T* to = out.view().row(y);
    if (sizeof(T) == 1 && stride == 1) {
      std::memcpy(to, from, image.width);
      continue;
    }
    for (int x = 0; x < out.width(); ++x)
      to[x] = static_cast<T>(sampler.grey(from + static_cast<std::size_t>(x) * stride));
  }
}

}  // namespace

bool is_known_encoding(std::string_view encoding) { return encoding_named(encoding) != nullptr; }

bool is_mosaic_encoding(std::string_view encoding) {
  const Encoding* found = encoding_named(encoding);
  return found != nullptr && found->mosaic;
}

std::string to_grey(const RosImage& image, GreyPicture& picture) {
  const Encoding* encoding = encoding_named(image.encoding);
  if (encoding == nullptr) {
    return "its encoding is not known: record mono8, mono16, rgb8, bgr8, yuv422 or bayer images";
  }
  if (std::string refused = refuse_size(image.width, image.height); !refused.empty()) return refused;
  const std::uint64_t row = std::uint64_t{image.width} * static_cast<unsigned>(encoding->channels * encoding->bytes);
  if (image.step < row || (std::uint64_t{image.height} - 1) * image.step + row > image.data.size()) {
    return "copy the bag again: the image has fewer bytes than its size needs";
  }
  picture.deep = encoding->bytes == 2;
  picture.bits_in_use = 0;
  picture.warnings = 0;
  const Sampler sampler{*encoding, image.big_endian};
  if (picture.deep) {
    convert(image, sampler, picture.words);
  } else {
    convert(image, sampler, picture.bytes);
  }
  return {};
}

}  // namespace cliquevo::drivers
