// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <bit>

#include <fmt/format.h>

#include "drivers/images/decode_image.h"

namespace cliquevo::drivers {

namespace {

constexpr std::size_t kFileHeader = 14;
constexpr std::size_t kOldHeader = 12;
constexpr std::size_t kInfoHeader = 40;
constexpr std::uint32_t kUncompressed = 0;
constexpr std::uint32_t kBitFields = 3;

std::uint32_t number(Bytes file, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{file[at + i]} << (8U * i);
  return value;
}

struct BmpHeader {
  std::int64_t width = 0;
  std::int64_t height = 0;
  bool top_down = false;
  unsigned bits = 0;
  std::size_t pixels_at = 0;
  std::size_t palette_at = 0;
  std::size_t palette_entry = 4;
  std::size_t palette_size = 0;
  std::array<unsigned, 3> byte_of{2, 1, 0};  // red, green, blue in a pixel of 24 or 32 bits
};

// Where the masks put red, green and blue, if each is a whole byte.
bool read_masks(Bytes file, BmpHeader& out) {
  const std::size_t at = kFileHeader + kInfoHeader;
  if (file.size() < at + 12) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t mask = number(file, at + 4 * i, 4);
    const int shift = mask == 0 ? 1 : std::countr_zero(mask);
    if (shift % 8 != 0 || mask >> static_cast<unsigned>(shift) != 255U) return false;
    out.byte_of[i] = static_cast<unsigned>(shift) / 8U;
  }
  return true;
}

std::string read_header(Bytes file, BmpHeader& out) {
  if (file.size() < kFileHeader + kOldHeader) return kTorn;
  out.pixels_at = number(file, 10, 4);
  const std::size_t size = number(file, 14, 4);
  const bool old = size == kOldHeader;
  if (!old && (size < kInfoHeader || file.size() < kFileHeader + kInfoHeader)) return kTorn;
  out.width = old ? number(file, 18, 2) : std::int64_t{static_cast<std::int32_t>(number(file, 18, 4))};
  out.height = old ? number(file, 20, 2) : std::int64_t{static_cast<std::int32_t>(number(file, 22, 4))};
  out.top_down = out.height < 0;
  if (out.top_down) out.height = -out.height;
  out.bits = number(file, old ? 24 : 28, 2);
  const std::uint32_t compression = old ? kUncompressed : number(file, 30, 4);
  const bool masks = compression == kBitFields && out.bits == 32;
  const bool plain = compression == kUncompressed &&
                     (out.bits == 1 || out.bits == 4 || out.bits == 8 || out.bits == 24 || out.bits == 32);
  if ((!plain && !masks) || (masks && !read_masks(file, out))) {
    return fmt::format("its kind of BMP ({} bits, compression {}) is not read: convert it to PNG", out.bits,
                       compression);
  }
  out.palette_at = kFileHeader + size;
  out.palette_entry = old ? 3 : 4;
  const std::size_t stated = old ? 0 : number(file, 46, 4);
  out.palette_size = out.bits > 8 ? 0 : stated == 0 ? std::size_t{1} << out.bits : std::min<std::size_t>(stated, 256);
  return {};
}

std::array<std::uint8_t, 256> read_palette(Bytes file, const BmpHeader& header) {
  std::array<std::uint8_t, 256> grey{};
  for (std::size_t i = 0; i < header.palette_size; ++i) {
    const std::uint8_t* entry = file.data() + header.palette_at + i * header.palette_entry;
    grey[i] = static_cast<std::uint8_t>(grey_of_rgb(entry[2], entry[1], entry[0]));
  }
  return grey;
}

}  // namespace

bool is_bmp(Bytes file) { return file.size() >= 2 && file[0] == 'B' && file[1] == 'M'; }

std::string decode_bmp(Bytes file, GreyPicture& picture) {
  BmpHeader header;
  if (std::string bad = read_header(file, header); !bad.empty()) return bad;
  if (std::string refused = refuse_size(header.width, header.height); !refused.empty()) return refused;
  const std::size_t stride = (static_cast<std::size_t>(header.width) * header.bits + 31) / 32 * 4;
  const std::size_t needed = stride * static_cast<std::size_t>(header.height);
  if (header.pixels_at > file.size() || file.size() - header.pixels_at < needed) return kTorn;
  if (header.palette_at + header.palette_size * header.palette_entry > file.size()) return kTorn;
  const std::array<std::uint8_t, 256> palette = read_palette(file, header);
  const int width = static_cast<int>(header.width);
  const int height = static_cast<int>(header.height);
  picture.bytes.resize(width, height);
  for (int y = 0; y < height; ++y) {
    const int stored = header.top_down ? y : height - 1 - y;
    const std::uint8_t* from = file.data() + header.pixels_at + stride * static_cast<std::size_t>(stored);
    std::uint8_t* to = picture.bytes.view().row(y);
    for (int x = 0; x < width; ++x) {
      const unsigned at = static_cast<unsigned>(x) * header.bits;
      if (header.bits <= 8) {
        const unsigned index = from[at / 8] >> (8 - header.bits - at % 8) & ((1U << header.bits) - 1U);
        to[x] = palette[index];
      } else {
        const std::uint8_t* p = from + at / 8;
        to[x] =
            static_cast<std::uint8_t>(grey_of_rgb(p[header.byte_of[0]], p[header.byte_of[1]], p[header.byte_of[2]]));
      }
    }
  }
  return {};
}

}  // namespace cliquevo::drivers
