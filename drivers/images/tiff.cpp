// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <tiffio.h>
#include <vector>

#include <fmt/format.h>

#include "drivers/images/decode_image.h"

namespace cliquevo::drivers {

namespace {

constexpr tmsize_t kMostOfOneTag = 64 << 20;
constexpr std::uint32_t kMostTile = 4096;  // px a side
constexpr std::size_t kSmallTile = std::size_t{1} << 20U;

// The file in memory, as libtiff reads it. It is not mapped: reads are checked here.
struct Source {
  Bytes file;
  std::uint64_t at = 0;
};

tmsize_t read_bytes(thandle_t handle, void* to, tmsize_t wanted) {
  auto& source = *static_cast<Source*>(handle);
  if (wanted <= 0 || source.at >= source.file.size()) return 0;
  const std::size_t count = std::min<std::size_t>(static_cast<std::size_t>(wanted), source.file.size() - source.at);
  std::memcpy(to, source.file.data() + source.at, count);
  source.at += count;
  return static_cast<tmsize_t>(count);
}
tmsize_t write_nothing(thandle_t, void*, tmsize_t) { return 0; }
toff_t seek_to(thandle_t handle, toff_t offset, int whence) {
  auto& source = *static_cast<Source*>(handle);
  source.at = offset + (whence == SEEK_CUR ? source.at : whence == SEEK_END ? source.file.size() : 0);
  return source.at;
}
int close_nothing(thandle_t) { return 0; }
toff_t size_of(thandle_t handle) { return static_cast<Source*>(handle)->file.size(); }
int map_nothing(thandle_t, void**, toff_t*) { return 0; }
void unmap_nothing(thandle_t, void*, toff_t) {}
int say_nothing(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using File = std::unique_ptr<TIFF, Close>;

File open(Source& source) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  if (options == nullptr) return nullptr;
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMostOfOneTag);
  TIFFOpenOptionsSetErrorHandlerExtR(options, say_nothing, nullptr);
  TIFFOpenOptionsSetWarningHandlerExtR(options, say_nothing, nullptr);
  File tiff(TIFFClientOpenExt("image", "rm", &source, read_bytes, write_nothing, seek_to, close_nothing, size_of,
                              map_nothing, unmap_nothing, options));
  TIFFOpenOptionsFree(options);
  return tiff;
}

struct TiffHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 0;
  std::uint16_t samples = 0;
  std::uint16_t photometric = 0;
  bool separate = false;  // a plane a colour

  bool colour() const { return photometric == PHOTOMETRIC_RGB; }
};

// Bytes of pixels that a byte of the file can stand for, at most; 0 = a packing that is not read.
std::uint64_t expansion_of(std::uint16_t compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return 64;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return 1032;
    case COMPRESSION_LZW:
      return 2731;
    default:
      return 0;
  }
}

std::string read_header(TIFF* tiff, std::size_t file_size, TiffHeader& out) {
  std::uint16_t compression = 0;
  std::uint16_t planes = 0;
  std::uint16_t kind = 0;
  if (TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &out.width) == 0) return kTorn;
  if (TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &out.height) == 0) return kTorn;
  if (std::string refused = refuse_size(out.width, out.height); !refused.empty()) return refused;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &out.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &out.samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planes);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &kind);
  if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &out.photometric) == 0) out.photometric = PHOTOMETRIC_MINISBLACK;
  out.separate = planes == PLANARCONFIG_SEPARATE;
  const std::uint64_t expansion = expansion_of(compression);
  const bool grey = out.photometric == PHOTOMETRIC_MINISBLACK || out.photometric == PHOTOMETRIC_MINISWHITE;
  const bool samples =
      out.colour() ? out.samples >= 3 && out.samples <= 4 : grey && out.samples >= 1 && out.samples <= 2;
  if (expansion > 0 && samples && (out.bits == 8 || out.bits == 16) && kind == SAMPLEFORMAT_UINT) {
    const std::uint64_t bytes = std::uint64_t{out.width} * out.height * out.samples * out.bits / 8U;
    return bytes > file_size * expansion ? kTorn : "";
  }
  return fmt::format(
      "its kind of TIFF ({} samples of {} bits, photometric {}, compression {}) is not read: convert it to PNG",
      out.samples, out.bits, out.photometric, compression);
}

// Rows or tiles as they come, into `all`: samples side by side, `channels` a pixel.
template <typename T>
class Pixels {
 public:
  Pixels(TIFF* tiff, const TiffHeader& header)
      : tiff_(tiff),
        header_(header),
        channels_(header.colour() ? 3 : 1),
        stored_(header.separate ? 1U : header.samples) {}

  bool read(ImageView<T> out) {
    planes_ = header_.separate ? channels_ : 1U;
    return TIFFIsTiled(tiff_) != 0 ? read_tiles(out) : read_strips(out);
  }

 private:
  // A whole band of rows, so that strips whose planes lie apart come together.
  bool read_strips(ImageView<T> out) {
    std::uint32_t rows = 0;
    TIFFGetFieldDefaulted(tiff_, TIFFTAG_ROWSPERSTRIP, &rows);
    rows = std::clamp<std::uint32_t>(rows, 1, header_.height);
    const std::size_t row = std::size_t{header_.width} * stored_;
    for (std::uint32_t y = 0; y < header_.height; y += rows) {
      const std::uint32_t count = std::min(rows, header_.height - y);
      for (std::uint32_t plane = 0; plane < planes_; ++plane) {
        std::vector<T>& data = planes_data_[plane];
        data.resize(row * count);
        const auto size = static_cast<tmsize_t>(data.size() * sizeof(T));
        const std::uint32_t strip = TIFFComputeStrip(tiff_, y, static_cast<std::uint16_t>(plane));
        if (TIFFReadEncodedStrip(tiff_, strip, data.data(), size) != size) return false;
      }
      for (std::uint32_t i = 0; i < count; ++i) put_row(row * i, out.row(static_cast<int>(y + i)), header_.width);
    }
    return true;
  }

  bool read_tiles(ImageView<T> out) {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    TIFFGetField(tiff_, TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(tiff_, TIFFTAG_TILELENGTH, &height);
    if (width == 0 || height == 0 || width > kMostTile || height > kMostTile) return false;
    // A tile may reach beyond the image, but not by far.
    const std::size_t image = std::size_t{header_.width} * header_.height;
    if (std::size_t{width} * height > std::max(kSmallTile, 4 * image)) return false;
    const std::size_t row = std::size_t{width} * stored_;
    for (std::uint32_t y = 0; y < header_.height; y += height) {
      for (std::uint32_t x = 0; x < header_.width; x += width) {
        for (std::uint32_t plane = 0; plane < planes_; ++plane) {
          std::vector<T>& data = planes_data_[plane];
          data.resize(row * height);
          const auto size = static_cast<tmsize_t>(data.size() * sizeof(T));
          const std::uint32_t tile = TIFFComputeTile(tiff_, x, y, 0, static_cast<std::uint16_t>(plane));
          if (TIFFReadEncodedTile(tiff_, tile, data.data(), size) != size) return false;
        }
        const std::uint32_t columns = std::min(width, header_.width - x);
        const std::uint32_t rows = std::min(height, header_.height - y);
        for (std::uint32_t i = 0; i < rows; ++i) {
          put_row(row * i, out.row(static_cast<int>(y + i)) + x, columns);
        }
      }
    }
    return true;
  }

  void put_row(std::size_t at, T* to, std::uint32_t count) const {
    const bool inverted = header_.photometric == PHOTOMETRIC_MINISWHITE;
    for (std::uint32_t x = 0; x < count; ++x) {
      unsigned value = 0;
      if (channels_ == 1) {
        value = planes_data_[0][at + x * stored_];
      } else if (planes_ == 1) {
        const T* p = planes_data_[0].data() + at + x * stored_;
        value = grey_of_rgb(p[0], p[1], p[2]);
      } else {
        value = grey_of_rgb(planes_data_[0][at + x], planes_data_[1][at + x], planes_data_[2][at + x]);
      }
      to[x] = static_cast<T>(inverted ? ~value : value);
    }
  }

  TIFF* tiff_;
  const TiffHeader& header_;
  std::size_t channels_;
  std::size_t stored_;  // samples a pixel in one plane
  std::size_t planes_ = 1;
  std::vector<T> planes_data_[3];
};

}  // namespace

bool is_tiff(Bytes file) {
  if (file.size() < 8 || file[0] != file[1]) return false;
  return (file[0] == 'I' && (file[2] == 42 || file[2] == 43) && file[3] == 0) ||
         (file[0] == 'M' && file[2] == 0 && (file[3] == 42 || file[3] == 43));
}

std::string decode_tiff(Bytes file, GreyPicture& picture) {
  Source source{file};
  const File tiff = open(source);
  if (!tiff) return kTorn;
  TiffHeader header;
  if (std::string bad = read_header(tiff.get(), file.size(), header); !bad.empty()) return bad;
  const int width = static_cast<int>(header.width);
  const int height = static_cast<int>(header.height);
  picture.deep = header.bits == 16;
  bool done = false;
  if (picture.deep) {
    picture.words.resize(width, height);
    done = Pixels<std::uint16_t>(tiff.get(), header).read(picture.words.view());
  } else {
    picture.bytes.resize(width, height);
    done = Pixels<std::uint8_t>(tiff.get(), header).read(picture.bytes.view());
  }
  return done ? std::string() : kTorn;
}

}  // namespace cliquevo::drivers
