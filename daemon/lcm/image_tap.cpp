// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/image_tap.h"

#include <algorithm>
#include <cstring>

namespace cliquevo::daemon {

namespace {
std::int64_t period_of(double rate_hz) { return rate_hz > 0.0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0; }
}  // namespace

ImageTap::ImageTap(int width, int height, double rate_hz)
    : period_ns_(period_of(rate_hz)), images_(std::make_unique<TappedImages>()) {
  if (rate_hz <= 0.0) return;
  images_->left.resize(width, height);
  images_->left.fill(0);  // touched: the pages are there
  images_->disparity.resize(width, height);
  images_->disparity.fill(0);
}

void ImageTap::set_rate(double rate_hz) {
  if (period_ns_.load(std::memory_order_relaxed) > 0 && rate_hz > 0.0) {
    period_ns_.store(period_of(rate_hz), std::memory_order_relaxed);
  }
}

void ImageTap::offer(TimestampNs stamp_ns, ImageView<const std::uint8_t> left,
                     ImageView<const std::int16_t> disparity) {
  const std::int64_t period_ns = period_ns_.load(std::memory_order_relaxed);
  if (period_ns == 0 || full_.load(std::memory_order_acquire)) return;
  // A stamp before the last one: the source began anew.
  if (has_last_ && stamp_ns >= last_ns_ && stamp_ns - last_ns_ < period_ns) return;
  has_last_ = true;
  last_ns_ = stamp_ns;
  images_->stamp_ns = stamp_ns;
  const ImageView<std::uint8_t> left_copy = images_->left.view();
  const ImageView<std::uint16_t> disparity_copy = images_->disparity.view();
  const int height = std::min(left.height, left_copy.height);
  const int width = std::min(left.width, left_copy.width);
  for (int y = 0; y < height; ++y) {
    std::memcpy(left_copy.row(y), left.row(y), static_cast<std::size_t>(width));
    const std::int16_t* from = disparity.row(y);
    std::uint16_t* to = disparity_copy.row(y);
    for (int x = 0; x < width; ++x) to[x] = static_cast<std::uint16_t>(std::max<std::int16_t>(from[x], 0));
  }
  full_.store(true, std::memory_order_release);
}

}  // namespace cliquevo::daemon
