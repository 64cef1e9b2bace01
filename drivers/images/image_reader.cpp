// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/image_reader.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "drivers/images/decode_image.h"
#include "drivers/images/sample_depth.h"

namespace cliquevo::drivers {

namespace {

constexpr std::uintmax_t kMostBytes = 512U << 20U;

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

Result<void> ImageReader::decode(const std::uint8_t* bytes, std::size_t size, const std::string& name) {
  if (const std::string bad = decode_image({bytes, size}, picture_); !bad.empty()) {
    return Error{"cannot read image", name, bad};
  }
  if (picture_.warnings > 0) ++warned_;
  return {};
}

Result<const GreyPicture*> ImageReader::read_as_stored(const std::string& path) {
  if (Result<void> loaded = load(path, bytes_); !loaded) return loaded.error();
  if (Result<void> done = decode(bytes_.data(), bytes_.size(), path); !done) return done.error();
  return &picture_;
}

Result<void> ImageReader::read(const std::string& path, Image<std::uint8_t>& image) {
  if (Result<void> loaded = load(path, bytes_); !loaded) return loaded;
  return decode(bytes_.data(), bytes_.size(), path, image);
}

Result<void> ImageReader::decode(const std::uint8_t* bytes, std::size_t size, const std::string& name,
                                 Image<std::uint8_t>& image) {
  // The image's own memory is decoded into: in a sequence nothing is copied or allocated.
  std::swap(image, picture_.bytes);
  Result<void> done = decode(bytes, size, name);
  std::swap(image, picture_.bytes);
  if (!done || !picture_.deep) return done;
  SampleDepth depth;
  if (!shift_) depth.add(picture_);
  shift_to_bytes(picture_.words.cview(), shift_.value_or(depth.shift()), image);
  return {};
}

}  // namespace cliquevo::drivers
