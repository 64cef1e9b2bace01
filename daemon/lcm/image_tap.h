// SPDX-License-Identifier: BSD-3-Clause
// Copies of the odometry's images at a low rate, for displays: VO_IMAGES. The odometry thread gives, the
// output thread takes; neither waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/image.h"
#include "core/base/time.h"

namespace cliquevo::daemon {

struct TappedImages {
  TimestampNs stamp_ns = 0;
  Image<std::uint8_t> left;        // rectified
  Image<std::uint16_t> disparity;  // px * 16; 0 = unknown, or not above 0
  Image<std::uint8_t> right;       // rectified; empty where nobody wants it
  // Of the left image, zlib's format, a byte a pixel, 0 = no features there; empty = none are left out. The same in
  // every picture.
  std::vector<std::uint8_t> zipped_mask;
};

struct ImageTapOptions {
  int width = 0;
  int height = 0;
  double rate_hz = 0.0;                     // pictures a second at most, of the frames' own time; 0 = none ever
  bool right = false;                       // the right image, too
  ImageView<const std::uint8_t> mask = {};  // is copied
};

class ImageTap {
 public:
  // Takes all its memory here.
  explicit ImageTap(const ImageTapOptions& options);

  // Any thread: another rate, more than 0. Nothing happens where there was none to begin with.
  void set_rate(double rate_hz);

  // Odometry thread: copies when a picture is due and the last one has been taken. No allocation, no lock.
  // All of the agreed size; `right` may be empty where nobody wants it.
  void offer(TimestampNs stamp_ns, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             ImageView<const std::int16_t> disparity);

  // Output thread: what was copied since, or nullptr; good until give_back().
  const TappedImages* take() const { return full_.load(std::memory_order_acquire) ? images_.get() : nullptr; }
  void give_back() { full_.store(false, std::memory_order_release); }

 private:
  std::atomic<std::int64_t> period_ns_;  // 0 = off
  bool has_last_ = false;
  TimestampNs last_ns_ = 0;
  std::unique_ptr<TappedImages> images_;
  std::atomic<bool> full_{false};
};

}  // namespace cliquevo::daemon
