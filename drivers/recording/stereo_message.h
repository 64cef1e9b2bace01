// SPDX-License-Identifier: BSD-3-Clause
// A pair as a message (images_t), written and read without copying the pixels twice.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

inline constexpr const char* kStereoChannel = "VO_STEREO";
inline constexpr const char* kCalibrationChannel = "VO_CALIBRATION";

// Into `out`, whose memory is reused.
void encode_stereo(const StereoPair& pair, std::vector<std::uint8_t>& out);

// One image of a message: where its pixels are, or the JPEG that holds them.
struct StereoMessageSide {
  ImageView<const std::uint8_t> image;
  const std::uint8_t* jpeg = nullptr;
  std::size_t jpeg_size = 0;
  TimestampNs stamp_ns = 0;
  TimestampNs host_ns = 0;  // 0 = not given
};
struct StereoMessage {
  StereoMessageSide left;
  StereoMessageSide right;
};

// Views into `data`. Needs a left and a right image, grey with 8 bits or motion JPEG; an error's `where` is `name`.
Result<StereoMessage> parse_stereo(const std::uint8_t* data, std::size_t size, const std::string& name);

// A message's beginning: its time, and where the first image's metadata begin.
struct StereoMessageStart {
  std::optional<std::int64_t> utime;
  std::int64_t metadata_at = 0;  // 0 = not given: the first image is not the left one
};
StereoMessageStart parse_stereo_start(const std::uint8_t* data, std::size_t size);
// The exposure among the metadata [ns].
std::optional<TimestampNs> parse_stereo_stamp(const std::uint8_t* metadata, std::size_t size);
// Whether a message's beginning is that of an images_t with a left and a right image.
bool is_stereo_message(const std::uint8_t* data, std::size_t size);

}  // namespace cliquevo::drivers
