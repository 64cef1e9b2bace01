// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <spng.h>
#include <vector>
#include <zlib.h>

#include "drivers/images/decode_image.h"

namespace cliquevo::drivers {

namespace {

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::size_t kMostExpansion = 1032;  // of deflate
constexpr std::size_t kMostOfAChunk = 16U << 20U;
constexpr std::size_t kMostOfAllChunks = 64U << 20U;

struct Free {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, Free>;

std::uint32_t big_endian_32(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24U | std::uint32_t{p[1]} << 16U | std::uint32_t{p[2]} << 8U | std::uint32_t{p[3]};
}

// Length, type, data, CRC of type and data; to IEND. false: torn. Gives the length of the compressed pixels.
bool check_chunks(Bytes file, std::size_t& compressed) {
  compressed = 0;
  std::size_t at = kSignature.size();
  while (file.size() - at >= 12) {
    const std::size_t length = big_endian_32(file.data() + at);
    if (length > file.size() - at - 12) return false;
    const std::uint8_t* type = file.data() + at + 4;
    if (crc32_z(0, type, 4 + length) != big_endian_32(type + 4 + length)) return false;
    if (std::memcmp(type, "IEND", 4) == 0) return true;
    if (std::memcmp(type, "IDAT", 4) == 0) compressed += length;
    at += 12 + length;
  }
  return false;
}

int channels_of(const spng_ihdr& header) {
  switch (header.color_type) {
    case SPNG_COLOR_TYPE_TRUECOLOR:
      return 3;
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
      return 4;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      return 2;
    default:
      return 1;
  }
}

// A row of samples to grey; transparency is left aside.
template <typename T>
void to_grey_row(const T* from, int channels, int width, T* to) {
  if (channels <= 2) {
    for (int x = 0; x < width; ++x) to[x] = from[x * channels];
    return;
  }
  for (int x = 0; x < width; ++x, from += channels) to[x] = static_cast<T>(grey_of_rgb(from[0], from[1], from[2]));
}

struct PngSamples {
  int format;    // SPNG_FMT_*
  int channels;  // of a decoded row
  bool deep;
};

PngSamples samples_of(const spng_ihdr& header) {
  if (header.color_type == SPNG_COLOR_TYPE_GRAYSCALE && header.bit_depth <= 8) return {SPNG_FMT_G8, 1, false};
  if (header.color_type == SPNG_COLOR_TYPE_INDEXED) return {SPNG_FMT_RGB8, 3, false};
  return {SPNG_FMT_PNG, channels_of(header), header.bit_depth == 16};
}

template <typename T>
bool decode_pixels(spng_ctx* context, const spng_ihdr& header, const PngSamples& samples, ImageView<T> out) {
  const std::size_t row = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(samples.channels);
  if (header.interlace_method != SPNG_INTERLACE_NONE) {
    std::vector<T> all(row * static_cast<std::size_t>(out.height));
    if (spng_decode_image(context, all.data(), all.size() * sizeof(T), samples.format, 0) != 0) return false;
    for (int y = 0; y < out.height; ++y) {
      to_grey_row(all.data() + row * static_cast<std::size_t>(y), samples.channels, out.width, out.row(y));
    }
    return true;
  }
  if (spng_decode_image(context, nullptr, 0, samples.format, SPNG_DECODE_PROGRESSIVE) != 0) return false;
  std::vector<T> line(samples.channels == 1 ? 0 : row);
  for (int y = 0; y < out.height; ++y) {
    T* to = samples.channels == 1 ? out.row(y) : line.data();
    const int done = spng_decode_row(context, to, row * sizeof(T));
    if (done != 0 && !(done == SPNG_EOI && y == out.height - 1)) return false;
    if (samples.channels != 1) to_grey_row(to, samples.channels, out.width, out.row(y));
  }
  return true;
}

}  // namespace

bool is_png(Bytes file) {
  return file.size() >= kSignature.size() && std::equal(kSignature.begin(), kSignature.end(), file.begin());
}

std::string decode_png(Bytes file, GreyPicture& picture) {
  std::size_t compressed = 0;
  const Context context(spng_ctx_new(0));
  if (!context) return "there is no memory for it: use smaller images";
  spng_set_image_limits(context.get(), 0x7FFFFFFF, 0x7FFFFFFF);
  spng_set_chunk_limits(context.get(), kMostOfAChunk, kMostOfAllChunks);
  spng_ihdr header;
  if (spng_set_png_buffer(context.get(), file.data(), file.size()) != 0) return kTorn;
  if (spng_get_ihdr(context.get(), &header) != 0) return kTorn;
  if (std::string refused = refuse_size(header.width, header.height); !refused.empty()) return refused;
  if (!check_chunks(file, compressed)) return kTorn;
  const int width = static_cast<int>(header.width);
  const int height = static_cast<int>(header.height);
  const std::size_t bits = static_cast<std::size_t>(header.bit_depth) * static_cast<std::size_t>(channels_of(header));
  if ((bits * header.width + 7) / 8 * header.height > (compressed + 16) * kMostExpansion) return kTorn;
  const PngSamples samples = samples_of(header);
  picture.deep = samples.deep;
  if (samples.deep) {
    picture.words.resize(width, height);
    return decode_pixels(context.get(), header, samples, picture.words.view()) ? std::string() : kTorn;
  }
  picture.bytes.resize(width, height);
  return decode_pixels(context.get(), header, samples, picture.bytes.view()) ? std::string() : kTorn;
}

}  // namespace cliquevo::drivers
