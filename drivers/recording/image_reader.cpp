// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/image_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <zlib.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CLIQUEVO_THREAD_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define CLIQUEVO_THREAD_SANITIZER
#endif

#ifdef CLIQUEVO_THREAD_SANITIZER
// OpenCV initialises GDAL with its codecs, which takes two of its own locks in either order, in one thread.
extern "C" __attribute__((weak, no_sanitize_thread)) const char* __tsan_default_suppressions();  // NOLINT
extern "C" const char* __tsan_default_suppressions() { return "deadlock:libgdal\n"; }            // NOLINT
#endif

namespace cliquevo::drivers {

namespace {

constexpr std::array<std::uint8_t, 8> kPngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::uintmax_t kMostBytes = 512U << 20U;
constexpr int kMostPixels = 16384;  // a side

std::uint32_t big_endian_32(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24U | std::uint32_t{p[1]} << 16U | std::uint32_t{p[2]} << 8U | std::uint32_t{p[3]};
}

bool is_png(const std::uint8_t* bytes, std::size_t size) {
  return size >= kPngSignature.size() && std::equal(kPngSignature.begin(), kPngSignature.end(), bytes);
}

// length, type, data, CRC of type and data; to IEND.
bool png_is_whole(const std::uint8_t* bytes, std::size_t size) {
  std::size_t at = kPngSignature.size();
  while (size - at >= 12) {
    const std::size_t length = big_endian_32(bytes + at);
    if (length > size - at - 12) return false;
    const std::uint8_t* type = bytes + at + 4;
    const std::uint32_t crc = big_endian_32(type + 4 + length);
    if (crc32_z(0, type, 4 + length) != crc) return false;
    if (std::memcmp(type, "IEND", 4) == 0) return true;
    at += 12 + length;
  }
  return false;
}

// The decoder takes a cut JPEG and paints the rest grey; its end marker tells. Some writers pad with zeros.
bool jpeg_is_whole(const std::uint8_t* bytes, std::size_t size) {
  while (size > 2 && bytes[size - 1] == 0) --size;
  return size >= 4 && bytes[size - 2] == 0xFF && bytes[size - 1] == 0xD9;
}

Result<void> load(const std::string& path, std::vector<std::uint8_t>& bytes) {
  namespace fs = std::filesystem;
  std::error_code ec;
  const fs::file_status status = fs::status(path, ec);
  if (!fs::exists(status)) return Error{"no image", path, "copy the recording again: the file is missing"};
  if (!fs::is_regular_file(status)) return Error{"cannot read image", path, "it is not a regular file"};
  const std::uintmax_t size = fs::file_size(path, ec);
  if (ec) return Error{"cannot read image", path, ec.message()};
  if (size == 0) return Error{"cannot read image", path, "copy the recording again: the file is empty"};
  if (size > kMostBytes) return Error{"cannot read image", path, "it is above 512 MB: is it an image?"};
  bytes.resize(static_cast<std::size_t>(size));
  std::ifstream in(path, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    return Error{"cannot read image", path, "check its permissions and the disk"};
  }
  return {};
}

}  // namespace

bool image_is_whole(const std::uint8_t* bytes, std::size_t size) {
  if (is_png(bytes, size)) return png_is_whole(bytes, size);
  if (size >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF) return jpeg_is_whole(bytes, size);
  return size > 0;
}

Result<void> ImageReader::read(const std::string& path, Image<std::uint8_t>& image) {
  if (Result<void> loaded = load(path, bytes_); !loaded) return loaded;
  return decode(bytes_.data(), bytes_.size(), path, image);
}

Result<void> ImageReader::decode(const std::uint8_t* bytes, std::size_t size, const std::string& path,
                                 Image<std::uint8_t>& image) {
  // Before decoding: the decoders print lines of their own about torn files.
  if (!image_is_whole(bytes, size)) {
    return Error{"cannot read image", path, "copy the recording again: the file is torn"};
  }
  // Straight into our memory when the size is the one it already has (the rule in a sequence).
  cv::Mat target;
  if (!image.empty()) {
    const ImageView<std::uint8_t> view = image.view();
    target = cv::Mat(view.height, view.width, CV_8UC1, view.data, static_cast<std::size_t>(view.stride));
  }
  const std::uint8_t* own_memory = target.data;
  cv::Mat decoded;
  try {
    // As grabbed: a stored orientation must not turn the picture under the calibration.
    decoded = cv::imdecode(cv::Mat(1, static_cast<int>(size), CV_8UC1, const_cast<std::uint8_t*>(bytes)),
                           cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION, &target);
  } catch (const std::exception&) {
    decoded.release();
  }
  if (decoded.empty() || decoded.type() != CV_8UC1) {
    return Error{"cannot read image", path, "copy the recording again: the file is torn or no image"};
  }
  if (decoded.cols > kMostPixels || decoded.rows > kMostPixels) {
    return Error{"image is too big", path, "use images of at most 16384 px a side"};
  }
  if (decoded.data != own_memory || !image.view().same_size(decoded.cols, decoded.rows)) {
    image.copy_from(
        {decoded.ptr<std::uint8_t>(), decoded.cols, decoded.rows, static_cast<std::ptrdiff_t>(decoded.step1())});
  }
  return {};
}

}  // namespace cliquevo::drivers
