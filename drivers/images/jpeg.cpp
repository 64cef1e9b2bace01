// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/jpeg.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>

// jerror.h needs what jpeglib.h defines.
// clang-format off
#include <jpeglib.h>
#include <jerror.h>
// clang-format on

namespace cliquevo::drivers {

namespace {

constexpr long kMostMemory = 768L << 20U;  // of the decoder: progressive images are kept whole as coefficients
constexpr std::int64_t kMostScans = 40;
constexpr std::int64_t kFewScans = 12;
constexpr std::int64_t kMostWork = 1'000'000'000;  // pixels times scans

struct Decoder {
  jpeg_decompress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg_progress_mgr progress;
  std::jmp_buf back;
  bool end_missing = false;
};

Decoder& decoder_of(j_common_ptr info) { return *static_cast<Decoder*>(info->client_data); }

void give_up(j_common_ptr info) { std::longjmp(decoder_of(info).back, 1); }

// Every warning is counted; those that cost pixels (filled in, or from broken data) end the decoding.
void take_message(j_common_ptr info, int level) {
  if (level >= 0) return;  // traces
  ++info->err->num_warnings;
  switch (info->err->msg_code) {
    case JWRN_HIT_MARKER:         // bits are missing before a marker
    case JWRN_HUFF_BAD_CODE:      //
    case JWRN_ARITH_BAD_CODE:     //
    case JWRN_MUST_RESYNC:        // a stretch between restart markers is missing
    case JWRN_BOGUS_PROGRESSION:  //
      give_up(info);
      break;
    case JWRN_JPEG_EOF:
      decoder_of(info).end_missing = true;
      break;
    default:
      break;
  }
}

// Progressive images cost a pass over all pixels a scan; real ones have about ten.
void watch_scans(j_common_ptr info) {
  if (info->is_decompressor == FALSE) return;
  const auto& jpeg = *reinterpret_cast<j_decompress_ptr>(info);
  const std::int64_t pixels = std::int64_t{jpeg.image_width} * jpeg.image_height;
  const std::int64_t scans = jpeg.input_scan_number;
  if (scans > kMostScans || (scans > kFewScans && scans * pixels > kMostWork)) give_up(info);
}

void set_up(Decoder& d, const std::uint8_t* data, std::size_t size) {
  d.jpeg.err = jpeg_std_error(&d.errors);
  d.errors.error_exit = give_up;
  d.errors.emit_message = take_message;
  d.errors.output_message = [](j_common_ptr) {};
  d.jpeg.client_data = &d;
  jpeg_create_decompress(&d.jpeg);
  d.jpeg.client_data = &d;
  d.jpeg.mem->max_memory_to_use = kMostMemory;
  d.progress.progress_monitor = watch_scans;
  d.jpeg.progress = &d.progress;
  jpeg_mem_src(&d.jpeg, data, static_cast<unsigned long>(size));
}

// A progressive image without its end may lack the last scans: brightness must be there to the last bit.
bool luma_is_complete(const jpeg_decompress_struct& jpeg) {
  if (jpeg.coef_bits == nullptr) return true;
  const auto& bits = jpeg.coef_bits[0];
  return std::all_of(std::begin(bits), std::end(bits), [](int left) { return left == 0; });
}

// CMYK, which photo programs write (inverted, by Adobe's habit).
void cmyk_to_grey(const std::uint8_t* from, bool inverted, int width, std::uint8_t* to) {
  for (int x = 0; x < width; ++x, from += 4) {
    unsigned rgb[3];
    for (int i = 0; i < 3; ++i) {
      const unsigned ink = inverted ? from[i] : 255U - from[i];
      rgb[i] = ink * (inverted ? from[3] : 255U - from[3]) / 255U;
    }
    to[x] = static_cast<std::uint8_t>((9797U * rgb[0] + 19234U * rgb[1] + 3737U * rgb[2]) >> 15U);
  }
}

void read_rows(jpeg_decompress_struct& jpeg, ImageView<std::uint8_t> out) {
  const bool cmyk = jpeg.out_color_space == JCS_CMYK;
  JSAMPARRAY line = nullptr;
  if (cmyk) {
    line = (*jpeg.mem->alloc_sarray)(reinterpret_cast<j_common_ptr>(&jpeg), JPOOL_IMAGE, jpeg.output_width * 4, 1);
  }
  while (jpeg.output_scanline < jpeg.output_height) {
    const int y = static_cast<int>(jpeg.output_scanline);
    JSAMPROW row = cmyk ? line[0] : out.row(y);
    jpeg_read_scanlines(&jpeg, &row, 1);
    if (cmyk) cmyk_to_grey(row, jpeg.saw_Adobe_marker != 0, out.width, out.row(y));
  }
}

}  // namespace

bool read_jpeg_size(const std::uint8_t* data, std::size_t size, int& width, int& height) {
  Decoder d{};
  if (setjmp(d.back) != 0) {
    jpeg_destroy_decompress(&d.jpeg);
    return false;
  }
  set_up(d, data, size);
  const bool found = jpeg_read_header(&d.jpeg, TRUE) == JPEG_HEADER_OK;
  width = static_cast<int>(d.jpeg.image_width);
  height = static_cast<int>(d.jpeg.image_height);
  jpeg_destroy_decompress(&d.jpeg);
  return found;
}

JpegResult decode_jpeg(const std::uint8_t* data, std::size_t size, ImageView<std::uint8_t> out) {
  Decoder d{};
  if (setjmp(d.back) != 0) {
    const int warnings = static_cast<int>(d.errors.num_warnings);
    jpeg_destroy_decompress(&d.jpeg);
    return {false, warnings};
  }
  set_up(d, data, size);
  jpeg_read_header(&d.jpeg, TRUE);
  JpegResult result;
  if (static_cast<int>(d.jpeg.image_width) == out.width && static_cast<int>(d.jpeg.image_height) == out.height) {
    d.jpeg.out_color_space = d.jpeg.num_components == 4 ? JCS_CMYK : JCS_GRAYSCALE;
    jpeg_start_decompress(&d.jpeg);
    read_rows(d.jpeg, out);
    // What follows the last row (and may be missing) is of no interest; libjpeg has not to finish.
    result.whole = !d.end_missing || luma_is_complete(d.jpeg);
  }
  result.warnings = static_cast<int>(d.errors.num_warnings);
  jpeg_destroy_decompress(&d.jpeg);
  return result;
}

}  // namespace cliquevo::drivers
