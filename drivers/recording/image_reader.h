// SPDX-License-Identifier: BSD-3-Clause
// Image files to grey 8-bit images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"

namespace cliquevo::drivers {

// Keeps its buffers: one reader a thread.
class ImageReader {
 public:
  // Colour becomes grey by the BT.601 weights, 16-bit samples lose their low byte. Errors name the file: missing, no
  // image, torn (also where the decoder would have filled in grey silently), absurd size.
  Result<void> read(const std::string& path, Image<std::uint8_t>& image);
  // The same for a file in memory; `name` tells where it is from.
  Result<void> decode(const std::uint8_t* bytes, std::size_t size, const std::string& name, Image<std::uint8_t>& image);

 private:
  std::vector<std::uint8_t> bytes_;
};

// Whether the file is whole, as far as its container tells: PNG chunks with their checksums to the end chunk, a JPEG's
// end marker. Other formats pass. Exposed for tests.
bool image_is_whole(const std::uint8_t* bytes, std::size_t size);

}  // namespace cliquevo::drivers
