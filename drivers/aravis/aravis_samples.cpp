// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/aravis/aravis_samples.h"

#include <iterator>

namespace cliquevo::drivers {

namespace {

// Names that Aravis 0.8.26 has not (GenICam's list of pixel formats).
constexpr ArvPixelFormat kMono10p = 0x010a0046U;
constexpr ArvPixelFormat kMono12p = 0x010c0047U;

struct FormatRow {
  ArvPixelFormat formats[5];  // Mono, then the four patterns of Bayer
  AravisSamples samples;
};
constexpr FormatRow kFormats[] = {
    {{ARV_PIXEL_FORMAT_MONO_8, ARV_PIXEL_FORMAT_BAYER_BG_8, ARV_PIXEL_FORMAT_BAYER_GB_8, ARV_PIXEL_FORMAT_BAYER_GR_8,
      ARV_PIXEL_FORMAT_BAYER_RG_8},
     {8, {}, false}},
    {{ARV_PIXEL_FORMAT_MONO_10, ARV_PIXEL_FORMAT_BAYER_BG_10, ARV_PIXEL_FORMAT_BAYER_GB_10,
      ARV_PIXEL_FORMAT_BAYER_GR_10, ARV_PIXEL_FORMAT_BAYER_RG_10},
     {10, {}, false}},
    {{ARV_PIXEL_FORMAT_MONO_12, ARV_PIXEL_FORMAT_BAYER_BG_12, ARV_PIXEL_FORMAT_BAYER_GB_12,
      ARV_PIXEL_FORMAT_BAYER_GR_12, ARV_PIXEL_FORMAT_BAYER_RG_12},
     {12, {}, false}},
    {{ARV_PIXEL_FORMAT_MONO_14}, {14, {}, false}},
    {{ARV_PIXEL_FORMAT_MONO_16, ARV_PIXEL_FORMAT_BAYER_BG_16, ARV_PIXEL_FORMAT_BAYER_GB_16,
      ARV_PIXEL_FORMAT_BAYER_GR_16, ARV_PIXEL_FORMAT_BAYER_RG_16},
     {16, {}, false}},
    {{ARV_PIXEL_FORMAT_MONO_10_PACKED, ARV_PIXEL_FORMAT_BAYER_BG_10_PACKED, ARV_PIXEL_FORMAT_BAYER_GB_10_PACKED,
      ARV_PIXEL_FORMAT_BAYER_GR_10_PACKED, ARV_PIXEL_FORMAT_BAYER_RG_10_PACKED},
     {10, PackedSamples::gige_10_or_12, false}},
    {{ARV_PIXEL_FORMAT_MONO_12_PACKED, ARV_PIXEL_FORMAT_BAYER_BG_12_PACKED, ARV_PIXEL_FORMAT_BAYER_GB_12_PACKED,
      ARV_PIXEL_FORMAT_BAYER_GR_12_PACKED, ARV_PIXEL_FORMAT_BAYER_RG_12_PACKED},
     {12, PackedSamples::gige_10_or_12, false}},
    {{kMono10p, ARV_PIXEL_FORMAT_BAYER_BG_10P, ARV_PIXEL_FORMAT_BAYER_GB_10P, ARV_PIXEL_FORMAT_BAYER_GR_10P,
      ARV_PIXEL_FORMAT_BAYER_RG_10P},
     {10, PackedSamples::pfnc_10, false}},
    {{kMono12p, ARV_PIXEL_FORMAT_BAYER_BG_12P, ARV_PIXEL_FORMAT_BAYER_GB_12P, ARV_PIXEL_FORMAT_BAYER_GR_12P,
      ARV_PIXEL_FORMAT_BAYER_RG_12P},
     {12, PackedSamples::pfnc_12, false}},
};

}  // namespace

AravisSamples aravis_samples(ArvPixelFormat format) {
  for (const FormatRow& row : kFormats) {
    for (std::size_t i = 0; i < std::size(row.formats); ++i) {
      if (row.formats[i] != format || format == 0) continue;
      AravisSamples out = row.samples;
      out.mosaic = i > 0;
      return out;
    }
  }
  return {};
}

bool aravis_to_grey(const AravisSamples& samples, const std::uint8_t* data, std::size_t size,
                    ImageView<std::uint8_t> out) {
  if (samples.packed) return unpack_samples(*samples.packed, data, size, 0, out);
  const std::size_t bytes = samples.bits > 8 ? 2 : 1;
  const std::size_t row = bytes * static_cast<std::size_t>(out.width);
  if (size < row * static_cast<std::size_t>(out.height)) return false;
  for (int y = 0; y < out.height; ++y) {
    std::uint8_t* to = out.row(y);
    const std::uint8_t* from = data + row * static_cast<std::size_t>(y);
    for (int x = 0; x < out.width; ++x) {  // little-endian
      to[x] =
          bytes == 1 ? from[x] : static_cast<std::uint8_t>((from[2 * x] | from[2 * x + 1] << 8) >> (samples.bits - 8));
    }
  }
  return true;
}

}  // namespace cliquevo::drivers
