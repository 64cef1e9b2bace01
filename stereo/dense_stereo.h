// SPDX-License-Identifier: BSD-3-Clause
// The dense stereo stage on a rectified pair: pre-filter -> SAD block matching -> sub-pixel -> checks -> speckles.
#pragma once

#include <memory>
#include <thread>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "stereo/stereo_params.h"

namespace cliquevo::stereo {

// Disparity of rectified pairs of one size. One thread at a time.
class DenseStereo {
 public:
  // Allocates everything for images of this size; compute() allocates nothing.
  static Result<DenseStereo> make(const StereoParams& params, int width, int height);
  DenseStereo(DenseStereo&&) noexcept;
  DenseStereo& operator=(DenseStereo&&) noexcept;
  ~DenseStereo();

  // left, right: rectified, width x height. filtered_left: the pre-filtered left image (the paper's J), same size.
  // disparity: int16, px * 16, kUnknownDisparity where unknown; d = u_left - u_right.
  // Errors (null, overlapping or wrongly sized views) are named before any work.
  Result<void> compute(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                       ImageView<std::uint8_t> filtered_left, ImageView<std::int16_t> disparity);

  // As given to make().
  const StereoParams& params() const;
  // Of the workers beside the caller's thread, to be given a core and a priority.
  std::vector<std::thread::native_handle_type> worker_handles();

 private:
  struct Impl;
  explicit DenseStereo(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::stereo
