// SPDX-License-Identifier: BSD-3-Clause
// Pixel formats of GigE Vision and USB3 Vision cameras to grey.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/base/image.h"
#include "drivers/aravis/handles.h"
#include "drivers/images/packed_samples.h"

namespace cliquevo::drivers {

// What a pixel format of the camera is: its samples' bits (0 = not known), how they lie, whether they are a raw mosaic.
struct AravisSamples {
  int bits = 0;  // 8, or more in 16
  std::optional<PackedSamples> packed;
  bool mosaic = false;

  bool is_grey_bytes() const { return bits == 8 && !mosaic; }
};
AravisSamples aravis_samples(ArvPixelFormat format);
// To 8 bits, a mosaic still being one. false: the data is too short.
bool aravis_to_grey(const AravisSamples& samples, const std::uint8_t* data, std::size_t size,
                    ImageView<std::uint8_t> out);

}  // namespace cliquevo::drivers
