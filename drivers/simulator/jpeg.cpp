// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/jpeg.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <jpeglib.h>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

struct JpegFailure {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

jpeg_error_mgr* jumps_back(JpegFailure& failure) {
  jpeg_std_error(&failure.manager);
  failure.manager.error_exit = [](j_common_ptr info) {
    std::longjmp(reinterpret_cast<JpegFailure*>(info->err)->back, 1);
  };
  failure.manager.output_message = [](j_common_ptr) {};
  return &failure.manager;
}

// What libjpeg allocates: outlives a jump.
struct Compressed {
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): libjpeg's
  ~Compressed() { std::free(data); }
};

bool compress(int quality, ImageView<std::uint8_t> image, Compressed& out) {
  jpeg_compress_struct jpeg;
  JpegFailure failure;
  jpeg.err = jumps_back(failure);
  if (setjmp(failure.back) != 0) {
    jpeg_destroy_compress(&jpeg);
    return false;
  }
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &out.data, &out.size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width);
  jpeg.image_height = static_cast<JDIMENSION>(image.height);
  jpeg.input_components = 1;
  jpeg.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = image.row(static_cast<int>(jpeg.next_scanline));
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  return true;
}

bool decompress(const Compressed& from, ImageView<std::uint8_t> image) {
  jpeg_decompress_struct jpeg;
  JpegFailure failure;
  jpeg.err = jumps_back(failure);
  if (setjmp(failure.back) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, from.data, from.size);
  jpeg_read_header(&jpeg, TRUE);
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = image.row(static_cast<int>(jpeg.output_scanline));
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return true;
}

}  // namespace

int jpeg_quality_of(const SimulatorOptions& o, std::int64_t frame, int camera) {
  if (o.jpeg_quality <= 0) return 0;
  Random random(hash_cell(mix64(o.noise_seed ^ 0x6a706567ULL), frame, camera));
  const auto off = static_cast<int>(std::floor(random.uniform(-o.jpeg_spread, o.jpeg_spread + 1.0)));
  return std::clamp(o.jpeg_quality + off, 1, 100);
}

Result<void> through_jpeg(int quality, Image<std::uint8_t>& image) {
  Compressed compressed;
  if (compress(quality, image.view(), compressed) && decompress(compressed, image.view())) return {};
  return Error{"cannot compress a picture", "libjpeg", "free some memory"};
}

}  // namespace cliquevo::drivers::sim
