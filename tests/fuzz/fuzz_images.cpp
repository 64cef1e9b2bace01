// SPDX-License-Identifier: BSD-3-Clause
// Image files of every format, and what becomes of their pixels.
#include <cstring>
#include <vector>
#include <zlib.h>

#include "drivers/images/bayer.h"
#include "drivers/images/decode_image.h"
#include "drivers/images/sample_depth.h"
#include "tests/fuzz/expect.h"

namespace {

using namespace cliquevo;

// A PNG's checksums are set right, so that what is behind them is reached.
void mend_checksums(std::vector<std::uint8_t>& file) {
  if (!drivers::is_png(file)) return;
  for (std::size_t at = 8; file.size() - at >= 12;) {
    const std::uint8_t* p = file.data() + at;
    const std::size_t length = std::size_t{p[0]} << 24U | std::size_t{p[1]} << 16U | std::size_t{p[2]} << 8U | p[3];
    if (length > file.size() - at - 12) return;
    const auto crc = static_cast<std::uint32_t>(crc32_z(0, p + 4, 4 + length));
    for (unsigned i = 0; i < 4; ++i) file[at + 8 + length + i] = static_cast<std::uint8_t>(crc >> (24 - 8 * i));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> file(data, data + size);
  mend_checksums(file);
  drivers::GreyPicture picture;
  const std::string said = drivers::decode_image(file, picture);
  fuzz::expect(said.find_first_of("\n\r\x1b") == std::string::npos, "a refusal is one line: " + said);
  if (!said.empty()) return 0;
  const std::int64_t pixels = std::int64_t{picture.width()} * picture.height();
  fuzz::expect(picture.width() > 0 && picture.height() > 0 && pixels <= drivers::kMostPixels,
               "a size that is accepted");
  fuzz::expect(picture.bits_in_use >= 0 && picture.bits_in_use <= 16, "bits of a word");
  if (pixels > 1'000'000) return 0;
  drivers::SampleDepth depth;
  depth.add(picture);
  if (picture.deep) {
    fuzz::expect(depth.shift() >= 0 && depth.shift() <= 8, "a shift that leaves 8 bits");
    drivers::shift_to_bytes(picture.words.cview(), depth.shift(), picture.bytes);
  }
  drivers::MosaicEvidence evidence;
  evidence.add(picture.bytes.cview());
  (void)evidence.is_mosaic();
  drivers::MosaicToGrey().convert(picture.bytes.view());
  return 0;
}
