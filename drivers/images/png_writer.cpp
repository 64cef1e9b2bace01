// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/png_writer.h"

#include <cstdlib>
#include <memory>
#include <spng.h>

namespace cliquevo::drivers {

namespace {

struct FreeContext {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
struct FreeBytes {
  void operator()(void* bytes) const { std::free(bytes); }
};

template <typename T>
Result<std::vector<unsigned char>> encode(ImageView<const T> image, int channels) {
  const std::unique_ptr<spng_ctx, FreeContext> context(spng_ctx_new(SPNG_CTX_ENCODER));
  const Error failed{"cannot encode image", "PNG", "use a smaller image, or free memory"};
  if (!context || image.empty()) return failed;
  spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 1);
  spng_set_option(context.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  spng_ihdr header = {};
  header.width = static_cast<std::uint32_t>(image.width / channels);
  header.height = static_cast<std::uint32_t>(image.height);
  header.bit_depth = 8 * sizeof(T);
  header.color_type = channels == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE;
  if (spng_set_ihdr(context.get(), &header) != 0) return failed;
  const int begun =
      spng_encode_image(context.get(), nullptr, 0, SPNG_FMT_PNG, SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
  if (begun != 0) return failed;
  const std::size_t row = static_cast<std::size_t>(image.width) * sizeof(T);
  for (int y = 0; y < image.height; ++y) {
    const int done = spng_encode_row(context.get(), image.row(y), row);
    if (done != 0 && !(done == SPNG_EOI && y == image.height - 1)) return failed;
  }
  std::size_t size = 0;
  int error = 0;
  const std::unique_ptr<void, FreeBytes> bytes(spng_get_png_buffer(context.get(), &size, &error));
  if (!bytes || error != 0) return failed;
  const auto* begin = static_cast<const unsigned char*>(bytes.get());
  return std::vector<unsigned char>(begin, begin + size);
}

}  // namespace

Result<std::vector<unsigned char>> encode_png(ImageView<const std::uint8_t> grey) { return encode(grey, 1); }
Result<std::vector<unsigned char>> encode_png(ImageView<const std::uint16_t> grey) { return encode(grey, 1); }
Result<std::vector<unsigned char>> encode_png_rgb(ImageView<const std::uint8_t> rgb) { return encode(rgb, 3); }

}  // namespace cliquevo::drivers
