// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/pictures.h"

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <jpeglib.h>

#include "drivers/images/png_writer.h"

namespace cliquevo::view {

namespace {

struct Failure {
  jpeg_error_mgr base;  // first: libjpeg hands out a pointer to it
  std::jmp_buf out;
};

[[noreturn]] void leave(j_common_ptr info) { std::longjmp(reinterpret_cast<Failure*>(info->err)->out, 1); }

}  // namespace

struct JpegEncoder::Impl {
  jpeg_compress_struct info{};
  Failure failure{};
  unsigned char* memory = nullptr;  // libjpeg's, by malloc
  unsigned long size = 0;
  bool usable = false;
};

JpegEncoder::JpegEncoder() : impl_(new Impl) {
  impl_->info.err = jpeg_std_error(&impl_->failure.base);
  impl_->failure.base.error_exit = leave;
  if (setjmp(impl_->failure.out) != 0) return;
  jpeg_create_compress(&impl_->info);
  impl_->usable = true;
}

JpegEncoder::~JpegEncoder() {
  jpeg_destroy_compress(&impl_->info);
  std::free(impl_->memory);
  delete impl_;
}

Bytes JpegEncoder::encode(ImageView<const std::uint8_t> grey, int quality) {
  Impl& m = *impl_;
  if (!m.usable || grey.empty()) return {};
  // libjpeg does not free a buffer of ours that turns out too small: each picture gets its own.
  std::free(m.memory);
  m.memory = nullptr;
  m.size = 0;
  if (setjmp(m.failure.out) != 0) {
    jpeg_abort_compress(&m.info);
    m.memory = nullptr;  // it may have been replaced
    return {};
  }
  jpeg_mem_dest(&m.info, &m.memory, &m.size);
  m.info.image_width = static_cast<JDIMENSION>(grey.width);
  m.info.image_height = static_cast<JDIMENSION>(grey.height);
  m.info.input_components = 1;
  m.info.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&m.info);
  jpeg_set_quality(&m.info, quality, TRUE);
  jpeg_start_compress(&m.info, TRUE);
  while (m.info.next_scanline < m.info.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(grey.row(static_cast<int>(m.info.next_scanline)));  // libjpeg only reads it
    jpeg_write_scanlines(&m.info, &row, 1);
  }
  jpeg_finish_compress(&m.info);
  return {m.memory, m.memory + m.size};
}

DisparityPicture encode_disparity(ImageView<const std::int16_t> disparity) {
  DisparityPicture out;
  std::int16_t most = 1;
  for (int y = 0; y < disparity.height; ++y) {
    const std::int16_t* row = disparity.row(y);
    most = std::max(most, *std::max_element(row, row + disparity.width));
  }
  int step = 4;  // sixteenths of a px
  while (most / step > 254) step *= 2;
  out.step_px = static_cast<float>(step) / 16.0F;
  Image<std::uint8_t> levels(disparity.width, disparity.height);
  for (int y = 0; y < disparity.height; ++y) {
    const std::int16_t* from = disparity.row(y);
    std::uint8_t* to = levels.view().row(y);
    for (int x = 0; x < disparity.width; ++x) {
      to[x] =
          from[x] <= 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(std::clamp((from[x] + step / 2) / step, 1, 255));
    }
  }
  auto png = drivers::encode_png(levels.cview());
  if (png) out.png = std::move(*png);
  return out;
}

Bytes pack_features(const std::vector<vo::SeenFeature>& features) {
  constexpr std::size_t kSize = 28;
  Bytes out(kSize * features.size());
  unsigned char* to = out.data();
  for (const vo::SeenFeature& f : features) {
    const float numbers[] = {f.x_px, f.y_px, f.from_x_px, f.from_y_px, f.disparity_px, f.error_px};
    const auto role = static_cast<std::uint32_t>(f.role);
    std::memcpy(to, numbers, sizeof numbers);
    std::memcpy(to + sizeof numbers, &role, sizeof role);
    to += kSize;
  }
  return out;
}

Image<std::uint8_t> shrunk(ImageView<const std::uint8_t> grey, int width) {
  const int n = std::max(1, grey.width / std::max(1, width));
  Image<std::uint8_t> out(grey.width / n, grey.height / n);
  for (int y = 0; y < out.height(); ++y) {
    std::uint8_t* to = out.view().row(y);
    for (int x = 0; x < out.width(); ++x) {
      int sum = 0;
      for (int dy = 0; dy < n; ++dy) {
        for (int dx = 0; dx < n; ++dx) sum += grey.row(y * n + dy)[x * n + dx];
      }
      to[x] = static_cast<std::uint8_t>(sum / (n * n));
    }
  }
  return out;
}

}  // namespace cliquevo::view
