// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/image_tap.h"

#include <algorithm>
#include <cstring>
#include <zlib.h>

namespace cliquevo::daemon {

namespace {
std::int64_t period_of(double rate_hz) { return rate_hz > 0.0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0; }

std::vector<std::uint8_t> zipped(ImageView<const std::uint8_t> image) {
  const auto width = static_cast<std::size_t>(image.width);
  std::vector<std::uint8_t> rows(width * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(rows.data() + static_cast<std::size_t>(y) * width, image.row(y), width);
  }
  uLongf size = compressBound(rows.size());
  std::vector<std::uint8_t> out(size);
  if (compress(out.data(), &size, rows.data(), rows.size()) != Z_OK) return {};
  out.resize(size);
  return out;
}

void copy_rows(ImageView<const std::uint8_t> from, ImageView<std::uint8_t> to) {
  const auto width = static_cast<std::size_t>(std::min(from.width, to.width));
  for (int y = 0; y < std::min(from.height, to.height); ++y) std::memcpy(to.row(y), from.row(y), width);
}

}  // namespace

ImageTap::ImageTap(const ImageTapOptions& options)
    : period_ns_(period_of(options.rate_hz)), images_(std::make_unique<TappedImages>()) {
  if (options.rate_hz <= 0.0) return;
  images_->left.resize(options.width, options.height);
  images_->left.fill(0);  // touched: the pages are there
  images_->disparity.resize(options.width, options.height);
  images_->disparity.fill(0);
  if (options.right) {
    images_->right.resize(options.width, options.height);
    images_->right.fill(0);
  }
  if (!options.mask.empty()) images_->zipped_mask = zipped(options.mask);
}

void ImageTap::set_rate(double rate_hz) {
  if (period_ns_.load(std::memory_order_relaxed) > 0 && rate_hz > 0.0) {
    period_ns_.store(period_of(rate_hz), std::memory_order_relaxed);
  }
}

void ImageTap::offer(TimestampNs stamp_ns, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                     ImageView<const std::int16_t> disparity) {
  const std::int64_t period_ns = period_ns_.load(std::memory_order_relaxed);
  if (period_ns == 0 || full_.load(std::memory_order_acquire)) return;
  // A stamp before the last one: the source began anew.
  if (has_last_ && stamp_ns >= last_ns_ && stamp_ns - last_ns_ < period_ns) return;
  has_last_ = true;
  last_ns_ = stamp_ns;
  images_->stamp_ns = stamp_ns;
  copy_rows(left, images_->left.view());
  if (!images_->right.empty()) copy_rows(right, images_->right.view());
  const ImageView<std::uint16_t> disparity_copy = images_->disparity.view();
  const int height = std::min(disparity.height, disparity_copy.height);
  const int width = std::min(disparity.width, disparity_copy.width);
  for (int y = 0; y < height; ++y) {
    const std::int16_t* from = disparity.row(y);
    std::uint16_t* to = disparity_copy.row(y);
    for (int x = 0; x < width; ++x) to[x] = static_cast<std::uint16_t>(std::max<std::int16_t>(from[x], 0));
  }
  full_.store(true, std::memory_order_release);
}

}  // namespace cliquevo::daemon
