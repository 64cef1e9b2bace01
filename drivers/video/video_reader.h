// SPDX-License-Identifier: BSD-3-Clause
// A video file as numbered grey frames. Known to the programs and to the module that decodes: nothing of libav here.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

struct VideoInfo {
  int width = 0;
  int height = 0;
  std::string codec;                   // "h264"
  std::string container;               // "matroska,webm"
  std::vector<TimestampNs> stamps_ns;  // of each frame as the container has them, in the order in which they are shown
};

class VideoReader {
 public:
  virtual ~VideoReader() = default;
  virtual const VideoInfo& info() const = 0;
  // Frame i, cheapest in order; samples of more than 8 bits and of limited range are brought to 0 to 255. One thread at
  // a time.
  virtual Result<void> read(std::int64_t i, Image<std::uint8_t>& out) = 0;
};

// What the module has: this number, then the function. Rises with every change of this file.
inline constexpr int kVideoInterface = 1;
using VideoInterfaceFunction = int();
using VideoOpenFunction = void(const std::string& path, std::unique_ptr<VideoReader>& reader, Error& error);
inline constexpr const char* kVideoInterfaceName = "cliquevo_video_interface";
inline constexpr const char* kVideoOpenName = "cliquevo_video_open";

}  // namespace cliquevo::drivers
