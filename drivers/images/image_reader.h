// SPDX-License-Identifier: BSD-3-Clause
// Image files to grey 8-bit images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "drivers/images/grey_picture.h"

namespace cliquevo::drivers {

// Keeps its buffers: one reader a thread.
class ImageReader {
 public:
  // Colour becomes grey by the BT.601 weights; samples of more than 8 bits are shifted down, by set_shift() or as far
  // as this image alone shows. Errors name the file: missing, no image, torn (also where the decoder would have filled
  // in grey silently), absurd size (by the header, before anything is decoded).
  Result<void> read(const std::string& path, Image<std::uint8_t>& image);
  // The same for a file in memory; `name`: where it is from.
  Result<void> decode(const std::uint8_t* bytes, std::size_t size, const std::string& name, Image<std::uint8_t>& image);
  // As stored; the picture is valid until the next call.
  Result<const GreyPicture*> read_as_stored(const std::string& path);
  // For all images from here on: bits by which samples of more than 8 bits are shifted down.
  void set_shift(int shift) { shift_ = shift; }
  // Images so far whose decoder warned, although every pixel was there.
  std::int64_t warned() const { return warned_; }

 private:
  Result<void> decode(const std::uint8_t* bytes, std::size_t size, const std::string& name);

  std::vector<std::uint8_t> bytes_;
  GreyPicture picture_;
  std::optional<int> shift_;
  std::int64_t warned_ = 0;
};

}  // namespace cliquevo::drivers
