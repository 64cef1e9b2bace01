// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/images/made_images.h"

#include <fstream>
#include <iterator>
#include <zlib.h>

namespace cliquevo::test {

namespace {

void put_big_endian(File& file, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) file.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(File& file, const char* type, const File& data) {
  put_big_endian(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = file.size();
  file.insert(file.end(), type, type + 4);
  file.insert(file.end(), data.begin(), data.end());
  put_big_endian(file, static_cast<std::uint32_t>(crc32(0, file.data() + begin, 4 + static_cast<uInt>(data.size()))));
}

// Rows of a (sub-)image, each behind filter type 0.
void put_pass(File& raw, const PngKind& kind, int channels, int x0, int y0, int dx, int dy,
              const std::function<unsigned(int, int, int)>& sample) {
  for (int y = y0; y < kind.height && x0 < kind.width; y += dy) {
    raw.push_back(0);
    unsigned bits = 0;
    unsigned held = 0;
    for (int x = x0; x < kind.width; x += dx) {
      for (int c = 0; c < channels; ++c) {
        held = held << kind.depth | sample(x, y, c);
        bits += static_cast<unsigned>(kind.depth);
        for (; bits >= 8; bits -= 8) raw.push_back(static_cast<std::uint8_t>(held >> (bits - 8)));
      }
    }
    if (bits > 0) raw.push_back(static_cast<std::uint8_t>(held << (8 - bits)));
  }
}

}  // namespace

File make_png(const PngKind& kind, const std::function<unsigned(int, int, int)>& sample) {
  const int channels = kind.color_type == 2 ? 3 : kind.color_type == 4 ? 2 : kind.color_type == 6 ? 4 : 1;
  File raw;
  if (kind.interlaced) {  // Adam7
    constexpr int kPasses[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                   {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    for (const auto& p : kPasses) put_pass(raw, kind, channels, p[0], p[1], p[2], p[3], sample);
  } else {
    put_pass(raw, kind, channels, 0, 0, 1, 1, sample);
  }
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  File packed(size);
  compress(packed.data(), &size, raw.data(), static_cast<uLong>(raw.size()));
  packed.resize(size);
  File header;
  put_big_endian(header, kind.claimed_width != 0 ? kind.claimed_width : static_cast<std::uint32_t>(kind.width));
  put_big_endian(header, kind.claimed_height != 0 ? kind.claimed_height : static_cast<std::uint32_t>(kind.height));
  for (const int value : {kind.depth, kind.color_type, 0, 0, kind.interlaced ? 1 : 0}) {
    header.push_back(static_cast<std::uint8_t>(value));
  }
  File file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  put_chunk(file, "IHDR", header);
  if (!kind.palette.empty()) put_chunk(file, "PLTE", kind.palette);
  put_chunk(file, "IDAT", packed);
  put_chunk(file, "IEND", {});
  return file;
}

void put16(File& file, unsigned value) {
  file.push_back(static_cast<std::uint8_t>(value));
  file.push_back(static_cast<std::uint8_t>(value >> 8U));
}

void put32(File& file, std::uint32_t value) {
  put16(file, value & 0xFFFFU);
  put16(file, value >> 16U);
}

File read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

drivers::Bytes bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace cliquevo::test
